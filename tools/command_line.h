// SPDX-License-Identifier: BSD-3-Clause
// What all programs do with their arguments.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

namespace ladar_perception {

/// What main is to return at once: the arguments ask for help, or are wrong, which is said. Nothing
/// where the program goes on.
inline std::optional<int> parseArguments(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app->exit(error);  // --help
    std::string trouble = error.what();
    // CLI11 looks for what is missing before what it does not know, but who has mistyped an option
    // wants to hear of that.
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && app->remaining_size() > 0) {
      trouble = "unknown:";
      for (const std::string& word : app->remaining()) trouble += " " + word;
    }
    std::cerr << std::filesystem::path(argv[0]).filename().string() << ": " << trouble
              << " (see --help)\n";
    return 1;
  }
}

}  // namespace ladar_perception
