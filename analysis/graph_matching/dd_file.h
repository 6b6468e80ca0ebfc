// The `.dd` files of graph matching (Torresani, Kolmogorov & Rother; Swoboda et al. 2022):
//
//   c comment
//   p LEFT RIGHT ASSIGNMENTS PAIRS
//   a INDEX LEFT_NODE RIGHT_NODE COST      each index from 0 to ASSIGNMENTS - 1 once
//   e INDEX INDEX COST                     costs of a pair given twice add up
//   i0, i1, n0, n1                         coordinates and neighbours: read over
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "analysis/graph_matching/matching_problem.h"

namespace kinemesh {

/// The largest number of nodes on one side that a file may declare.
inline constexpr uint32_t max_matching_nodes = 1'000'000;

/// Throws InputError naming file and line for anything malformed. Memory grows with the lines that
/// are there, never with the counts that are promised.
MatchingProblem parse_dd(std::string_view text, const std::string& file_name);
MatchingProblem read_dd(const std::filesystem::path& path);
std::string format_dd(const MatchingProblem& problem);

}  // namespace kinemesh
