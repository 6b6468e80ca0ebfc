// The sample sessions of sample_c3d/, made anew: the same takes that make_samples wrote there.
#pragma once

#include <string>
#include <vector>

#include "tests/support/synthetic_take.h"

namespace kinemesh::test {

/// "anna_happy", "anna_surprise", "ben_happy", "ben_surprise": stems of the files.
const std::vector<std::string>& sample_names();
/// The only one with a label swap.
inline constexpr std::string_view sample_with_swap = "ben_surprise";

/// Throws UsageError for an unknown name.
SyntheticTake make_sample(const std::string& name);

/// The two subjects' faces and marker layouts.
std::shared_ptr<const SyntheticFace> sample_face(const std::string& subject);
MarkerLayout sample_layout(const std::string& subject);

}  // namespace kinemesh::test
