// SPDX-License-Identifier: BSD-3-Clause
#include "param_reader.h"

#include <stdexcept>

namespace ladar_perception {
namespace {

ParamValue fromXmlRpc(XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value);
    case XmlRpc::XmlRpcValue::TypeInt:
      return static_cast<int>(value);
    case XmlRpc::XmlRpcValue::TypeDouble:
      return static_cast<double>(value);
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    case XmlRpc::XmlRpcValue::TypeArray:
      return UnsupportedValue{"a list"};
    case XmlRpc::XmlRpcValue::TypeStruct:
      return UnsupportedValue{"a map"};
    default:
      return UnsupportedValue{"a value of another kind"};
  }
}

}  // namespace

ParamMap paramsOf(const ros::NodeHandle& private_handle) {
  ParamMap values;
  XmlRpc::XmlRpcValue tree;
  if (private_handle.getParam(private_handle.getNamespace(), tree) &&
      tree.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
    for (auto& entry : tree) {
      // diagnostic_updater reads its own parameter from the same namespace.
      if (entry.first != "diagnostic_period") values[entry.first] = fromXmlRpc(entry.second);
    }
  }
  return values;
}

std::string sourceName(const ros::NodeHandle& private_handle) {
  return "parameters in " + private_handle.getNamespace();
}

void checkFrame(const std::string& name, const std::string& frame, bool may_be_empty,
                std::vector<std::string>* violations) {
  if (frame.empty() && !may_be_empty) violations->push_back(name + ": must not be empty");
  if (!frame.empty() && frame[0] == '/') {
    violations->push_back(name + ": '" + frame + "' starts with a slash, which tf2 has no use for");
  }
}

void refuse(const std::vector<std::string>& violations, const std::string& source) {
  if (violations.empty()) return;
  std::string report = source + ": " + std::to_string(violations.size()) + " bad parameter" +
                       (violations.size() == 1 ? "" : "s");
  for (const std::string& violation : violations) report += "\n  - " + violation;
  throw std::runtime_error(report);
}

}  // namespace ladar_perception
