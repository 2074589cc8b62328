// SPDX-License-Identifier: BSD-3-Clause
// Inside a manager messages pass by pointer. The test's own process is the manager here.
#pragma once

#include <nodelet/loader.h>

#include <boost/make_shared.hpp>
#include <functional>
#include <string>

#include "ros_nodelets.h"

namespace ladar_perception::test {

/// Publishes a message; expects that a nodelet holds this very one, lets go of it once `finish` has
/// seen it handled, and leaves it as it was.
template <typename Message>
void expectPassesByPointer(const std::string& topic, const Message& message,
                           const std::function<bool(const ros::Publisher&)>& finish) {
  ros::Publisher publisher = ros::NodeHandle().advertise<Message>(topic, 100);
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0; }));
  auto sent = boost::make_shared<Message>(message);
  publisher.publish(sent);
  EXPECT_TRUE(waitFor([&] { return sent.use_count() > 1; }, 3.0));
  ASSERT_TRUE(finish(publisher));
  EXPECT_TRUE(waitFor([&] { return sent.use_count() == 1; })) << "it is let go of";
  EXPECT_TRUE(message == *sent) << "others hold the same message: it must not change";
}

}  // namespace ladar_perception::test
