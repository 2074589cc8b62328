// SPDX-License-Identifier: BSD-3-Clause
#include "state_file.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace ladar_perception {
namespace {

constexpr char kMagic[] = "LADARDS";
constexpr char kVersion = '1';
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kHashBytes = 8;
using Matrix34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

uint64_t hashOf(const char* data, std::size_t size) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (std::size_t i = 0; i < size; ++i) {
    hash = (hash ^ static_cast<uint8_t>(data[i])) * 0x100000001b3ULL;
  }
  return hash;
}

class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    putAll(&value, 1);
  }
  template <typename T>
  void putAll(const T* values, std::size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  void putPose(const Eigen::Isometry3d& T) {
    const Matrix34 rows = T.matrix().topRows<3>();
    putAll(rows.data(), 12);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Throws std::runtime_error at the end of the bytes.
class ByteReader {
 public:
  ByteReader(const char* data, std::size_t size) : at_(data), end_(data + size) {}

  template <typename T>
  T get() {
    T value;
    getAll(&value, 1);
    return value;
  }
  template <typename T>
  void getAll(T* values, std::size_t count) {
    if (count > left() / sizeof(T)) throw std::runtime_error("its payload ends too early");
    if (count > 0) std::memcpy(static_cast<void*>(values), at_, count * sizeof(T));
    at_ += count * sizeof(T);
  }
  template <typename T>
  void getVector(std::vector<T>* values, std::size_t count) {
    // Before memory is taken: a wrong length may be any number.
    if (count > left() / sizeof(T)) throw std::runtime_error("its payload ends too early");
    values->resize(count);
    getAll(values->data(), count);
  }
  Eigen::Isometry3d getPose() {
    Matrix34 rows;
    getAll(rows.data(), 12);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.matrix().topRows<3>() = rows;
    return T;
  }
  Matrix6d getMatrix6() {
    Matrix6d matrix;
    getAll(matrix.data(), 36);
    return matrix;
  }
  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

 private:
  const char* at_;
  const char* end_;
};

void putConstraint(const PoseConstraint& constraint, ByteWriter* out) {
  out->put(static_cast<int32_t>(constraint.from));
  out->put(static_cast<int32_t>(constraint.to));
  out->putPose(constraint.T_from_to);
  out->putAll(constraint.information.data(), 36);
  out->put(static_cast<uint8_t>(constraint.kind));
  out->put(static_cast<uint8_t>(constraint.enabled));
}

PoseConstraint getConstraint(ByteReader* in) {
  PoseConstraint constraint;
  constraint.from = in->get<int32_t>();
  constraint.to = in->get<int32_t>();
  constraint.T_from_to = in->getPose();
  constraint.information = in->getMatrix6();
  const auto kind = in->get<uint8_t>();
  if (kind > 1) throw std::runtime_error("a constraint is of kind " + std::to_string(kind));
  constraint.kind = static_cast<ConstraintKind>(kind);
  constraint.enabled = in->get<uint8_t>() != 0;
  return constraint;
}

void putPose(const StatePose& pose, const Eigen::Isometry3d& T_map_pose, ByteWriter* out) {
  out->put(pose.stamp_s);
  out->putPose(pose.T_odom_pose);
  out->putPose(T_map_pose);
  out->put(static_cast<uint8_t>(pose.step_covariance.has_value()));
  if (pose.step_covariance) out->putAll(pose.step_covariance->data(), 36);
  const PoseSamples none;
  const PoseSamples& samples = pose.samples ? *pose.samples : none;
  for (const std::size_t length : {samples.positions_m.size(), samples.normals.size(),
                                   samples.rgb.size(), samples.labels.size()}) {
    out->put(static_cast<uint32_t>(length));
  }
  out->putAll(samples.positions_m.data(), samples.positions_m.size());
  out->putAll(samples.normals.data(), samples.normals.size());
  out->putAll(samples.rgb.data(), samples.rgb.size());
  out->putAll(samples.labels.data(), samples.labels.size());
}

void checkLengths(const PoseSamples& samples) {
  const std::size_t count = samples.size();
  const auto fits = [&](std::size_t length) { return length == count || length == 0; };
  if (samples.normals.size() != count || !fits(samples.rgb.size()) ||
      !fits(samples.labels.size())) {
    throw std::runtime_error("fields of a cloud differ in length");
  }
}

void getPose(ByteReader* in, StateContents* contents) {
  StatePose pose;
  pose.stamp_s = in->get<double>();
  pose.T_odom_pose = in->getPose();
  contents->graph.addPose(in->getPose());
  if (in->get<uint8_t>() != 0) pose.step_covariance = in->getMatrix6();
  uint32_t lengths[4];
  in->getAll(lengths, 4);
  auto samples = std::make_shared<PoseSamples>();
  in->getVector(&samples->positions_m, lengths[0]);
  in->getVector(&samples->normals, lengths[1]);
  in->getVector(&samples->rgb, lengths[2]);
  in->getVector(&samples->labels, lengths[3]);
  checkLengths(*samples);
  pose.samples = std::move(samples);
  contents->poses.push_back(std::move(pose));
}

StateContents parse(ByteReader in, const PoseGraphOptions& options) {
  StateContents contents{{}, PoseGraph(options), {}, {}};
  const auto poses = in.get<uint32_t>();
  for (uint32_t i = 0; i < poses; ++i) getPose(&in, &contents);
  const auto constraints = in.get<uint32_t>();
  for (uint32_t i = 0; i < constraints; ++i) contents.graph.addConstraint(getConstraint(&in));
  const auto waiting = in.get<uint32_t>();
  for (uint32_t i = 0; i < waiting; ++i) {
    const PoseConstraint constraint = getConstraint(&in);
    // The graph checks those that it is given; these it is not given yet.
    const auto exists = [&](int pose) { return pose >= 0 && pose < contents.graph.size(); };
    std::string error = constraintError(constraint);
    if (!exists(constraint.from) || !exists(constraint.to)) error = "there is no such pose";
    if (!error.empty()) throw std::invalid_argument("a waiting constraint: " + error);
    contents.waiting.emplace_back(constraint, in.get<int32_t>());
  }
  ConstraintCounts& counts = contents.counts;
  for (uint64_t* count : {&counts.tried, &counts.accepted, &counts.diverged, &counts.low_overlap,
                          &counts.inconsistent, &counts.unconfirmed, &counts.waiting}) {
    *count = in.get<uint64_t>();
  }
  if (in.left() > 0) throw std::runtime_error("its payload is too long");
  return contents;
}

std::string payloadOf(const StateContents& contents) {
  ByteWriter out;
  out.put(static_cast<uint32_t>(contents.poses.size()));
  for (std::size_t i = 0; i < contents.poses.size(); ++i) {
    putPose(contents.poses[i], contents.graph.pose(static_cast<int>(i)), &out);
  }
  out.put(static_cast<uint32_t>(contents.graph.constraints().size()));
  for (const PoseConstraint& constraint : contents.graph.constraints()) {
    putConstraint(constraint, &out);
  }
  out.put(static_cast<uint32_t>(contents.waiting.size()));
  for (const auto& [constraint, hops] : contents.waiting) {
    putConstraint(constraint, &out);
    out.put(static_cast<int32_t>(hops));
  }
  const ConstraintCounts& counts = contents.counts;
  for (const uint64_t count : {counts.tried, counts.accepted, counts.diverged, counts.low_overlap,
                               counts.inconsistent, counts.unconfirmed, counts.waiting}) {
    out.put(count);
  }
  return out.bytes();
}

/// The payload's place in the file's bytes, once all around it is right.
ByteReader checkedPayload(const std::string& bytes) {
  if (bytes.compare(0, 7, kMagic) != 0) throw std::runtime_error("is no saved delayed state");
  if (bytes.size() < kHeaderBytes) throw std::runtime_error("is cut off");
  if (bytes[7] != kVersion) {
    throw std::runtime_error(std::string("has version ") + bytes[7] + " of the format, expected " +
                             kVersion);
  }
  ByteReader header(bytes.data() + 8, 8);
  const auto size = header.get<uint64_t>();
  if (size != bytes.size() - kHeaderBytes - kHashBytes) {
    throw std::runtime_error("is cut off or damaged: it has " + std::to_string(bytes.size()) +
                             " bytes, which do not fit a payload of " + std::to_string(size));
  }
  const char* payload = bytes.data() + kHeaderBytes;
  ByteReader trailer(payload + size, kHashBytes);
  if (trailer.get<uint64_t>() != hashOf(payload, size)) {
    throw std::runtime_error("is damaged: its checksum is wrong");
  }
  return {payload, size};
}

}  // namespace

void writeStateFile(const std::string& path, const StateContents& contents) {
  const std::string payload = payloadOf(contents);
  ByteWriter around;
  around.putAll(kMagic, 7);
  around.put(kVersion);
  around.put(static_cast<uint64_t>(payload.size()));
  const uint64_t hash = hashOf(payload.data(), payload.size());
  const std::string partial = path + ".partial";
  {
    std::ofstream file(partial, std::ios::binary);
    file << around.bytes() << payload;
    file.write(reinterpret_cast<const char*>(&hash), sizeof(hash));
    if (file.flush() && std::rename(partial.c_str(), path.c_str()) == 0) return;
  }
  std::remove(partial.c_str());
  throw std::runtime_error(path + ": cannot be written");
}

StateContents readStateFile(const std::string& path, const PoseGraphOptions& options) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be opened");
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  try {
    return parse(checkedPayload(bytes), options);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  } catch (const std::invalid_argument& error) {  // of a constraint
    throw std::runtime_error(path + ": contradicts itself: " + error.what());
  }
}

}  // namespace ladar_perception
