// Lists of steps in TOML: an array of tables, each with plain values.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// One table of the array.
struct TomlStep {
  struct Value {
    std::string key;
    std::vector<std::string> words;  ///< as a user would type them; several from a list
    bool list = false;
    std::size_t line = 0;
  };
  std::size_t line = 0;
  std::vector<Value> values;
};

/// The tables [[array]] of a document that holds nothing else. Throws UsageError naming file, line
/// and key for a syntax error, another key or a value that is a table.
std::vector<TomlStep> read_toml_steps(std::string_view text, const std::string& file_name,
                                      const std::string& array);

}  // namespace kinemesh
