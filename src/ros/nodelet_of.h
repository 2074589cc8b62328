// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nodelet/nodelet.h>

#include <memory>

namespace ladar_perception {

/// The nodelet of a node that is made of two handles, the second private.
template <typename Node>
class NodeletOf : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      // The manager reports that loading failed, but not why: what() is lost on the way.
      NODELET_FATAL("%s", error.what());
      throw;
    }
  }

  std::unique_ptr<Node> node_;
};

}  // namespace ladar_perception
