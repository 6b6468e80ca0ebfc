// Takes a take's subjects out of everything that is written with it.
#pragma once

#include "capture/marker_sequence.h"

namespace kinemesh {

/// Subjects become S1, S2… in the order of the markers, in labels, events and parameters. Kept of a
/// C3D file's parameters are the groups that describe data (POINT, ANALOG, FORCE_PLATFORM, EVENT,
/// EVENT_CONTEXT, ROTATION, SUBJECTS) and what made them (MANUFACTURER), and the numbers of TRIAL;
/// everything else (patient data, measurements of the body, processing notes, names of files) is
/// dropped. Where a text still holds a subject's name, it is replaced. The file's path is
/// forgotten. Returns the number of subjects renamed.
std::size_t anonymise_take(MarkerSequence& take);

/// Subjects named anew, in markers, events and SUBJECTS parameters; equal new names merge them.
/// `rename(old)` gives the new name.
void rename_subjects(MarkerSequence& take,
                     const std::vector<std::pair<std::string, std::string>>& names);

}  // namespace kinemesh
