// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ladar_perception::test {

/// Expects that `action` throws an `Error` and that its message has all of `parts`.
template <typename Error, typename Action>
void expectError(Action action, const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const Error& error) {
    const std::string message = error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
    }
    return;
  }
  ADD_FAILURE() << "nothing was thrown, expected an error with " << parts.front();
}

}  // namespace ladar_perception::test
