// Events of a C3D file: up to 18 in the header, any number in the EVENT group.
#pragma once

#include <cstddef>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/c3d/parameters.h"
#include "mesh/event.h"

namespace kinemesh {

/// Events of the EVENT group, then those of the header that the group does not have too (a time
/// within 1 ms, and a label that begins with the header's four letters).
std::vector<Event> decode_event_list(const C3dParameters& parameters,
                                     const std::vector<C3dHeaderEvent>& header_events,
                                     std::vector<C3dFinding>& findings);

/// Brings the EVENT group up to date. What the group holds besides for an event that is still
/// there (icons, descriptions, flags) stays with it.
void encode_event_list(const std::vector<Event>& events, C3dParameters& parameters);

/// The first 18 events for the header block, in order of time.
std::vector<C3dHeaderEvent> header_events_of(const std::vector<Event>& events);

}  // namespace kinemesh
