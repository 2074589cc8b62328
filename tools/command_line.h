// SPDX-License-Identifier: BSD-3-Clause
// What all programs do with their arguments.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ladar_perception {

/// What main is to return at once: the arguments ask for help, or are wrong, which is said. Nothing
/// where the program goes on.
inline std::optional<int> parseArguments(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
  } catch (const CLI::RequiredError& error) {
    // CLI11 looks for what is missing before what it does not know, but who has mistyped an option
    // wants to hear of that.
    const std::vector<std::string> unknown = app->remaining();
    if (unknown.empty()) return app->exit(error);
    return app->exit(CLI::ExtrasError(app->get_name(), unknown));
  } catch (const CLI::ParseError& error) {
    return app->exit(error);
  }
  return std::nullopt;
}

}  // namespace ladar_perception
