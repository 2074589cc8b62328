// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/pose_graph.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <string>
#include <utility>

#include "pose_problem.h"

namespace ladar_perception {
namespace {

// Rounds of optimising and retiring; each is rarely more than a correction of the one before.
constexpr int kMaxReviews = 4;
// How much narrower each optimisation's robust kernel is than the one before.
constexpr double kNarrowing = 4.0;
// Weighs angles against metres where a constraint's uncertainty must be one number: about how far
// from a pose it is used.
constexpr double kLeverM = 10.0;

double lengthOf(const Matrix6d& covariance) {
  return covariance.topLeftCorner<3, 3>().trace() +
         kLeverM * kLeverM * covariance.bottomRightCorner<3, 3>().trace();
}

ceres::Solver::Options solverOptions(int max_iterations, bool is_last) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Not CHOLMOD, whose BLAS may use threads and round in another order from run to run.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.num_threads = 1;
  options.max_num_iterations = max_iterations;
  // What comes before the last kernel is only a start.
  options.function_tolerance = is_last ? 1e-9 : 1e-2;
  options.gradient_tolerance = 1e-9;
  options.parameter_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  return options;
}

/// Cauchy's kernel with a width that may be changed between optimisations.
class RobustKernel final : public ceres::LossFunction {
 public:
  double width = 1.0;
  void Evaluate(double chi2, double rho[3]) const override {
    ceres::CauchyLoss(width).Evaluate(chi2, rho);
  }
};

/// The part of a graph that one optimisation looks at.
class Problem {
 public:
  Problem(const PoseGraph& graph, const std::vector<int>& free) {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(options);
    kernel_.width = graph.options().robust_width;
    for (const int pose : free) problem_->AddParameterBlock(block(graph, pose), 7, &manifold_);
    std::vector<int> indices;
    for (const int pose : free) {
      const auto& at = graph.constraintsAt(pose);
      indices.insert(indices.end(), at.begin(), at.end());
    }
    std::sort(indices.begin(), indices.end());
    indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
    for (const int index : indices) add(graph, graph.constraints()[index]);
    for (auto& [pose, values] : blocks_) {
      if (problem_->GetManifold(values.data()) == nullptr) {
        problem_->SetParameterBlockConstant(values.data());
      }
    }
  }

  /// A right constraint that closes a long loop is as far off at first as a wrong one. So the
  /// kernel starts so wide that all pull, and is narrowed step by step (graduated non-convexity).
  OptimizeReport solve(int max_iterations) {
    OptimizeReport report;
    report.constraints = problem_->NumResidualBlocks();
    const double width = kernel_.width;
    for (kernel_.width = std::max(width, farthest_);; kernel_.width /= kNarrowing) {
      kernel_.width = std::max(kernel_.width, width);
      ceres::Solver::Summary summary;
      const bool is_last = kernel_.width <= width;
      ceres::Solve(solverOptions(max_iterations, is_last), problem_.get(), &summary);
      if (report.iterations == 0) report.initial_cost = summary.initial_cost;
      report.iterations += static_cast<int>(summary.iterations.size());
      report.residual_evaluations +=
          int64_t{summary.num_residual_evaluations} * problem_->NumResidualBlocks();
      report.final_cost = summary.final_cost;
      report.converged = summary.termination_type == ceres::CONVERGENCE;
      if (is_last) return report;
    }
  }

  Eigen::Isometry3d pose(int index) const { return fromBlock(blocks_.at(index).data()); }

 private:
  double* block(const PoseGraph& graph, int pose) {
    const auto [it, is_new] = blocks_.try_emplace(pose);
    if (is_new) it->second = toBlock(graph.pose(pose));
    return it->second.data();
  }

  void add(const PoseGraph& graph, const PoseConstraint& constraint) {
    if (!constraint.enabled) return;
    const bool robust = constraint.kind == ConstraintKind::kRegistration;
    problem_->AddResidualBlock(new ConstraintCost(constraint), robust ? &kernel_ : nullptr,
                               block(graph, constraint.from), block(graph, constraint.to));
    if (!robust) return;
    const double chi2 =
        constraintChi2(constraint, graph.pose(constraint.from), graph.pose(constraint.to));
    farthest_ = std::max(farthest_, std::sqrt(chi2));
  }

  PoseManifold manifold_;
  RobustKernel kernel_;
  double farthest_ = 0.0;            // of the registrations, in standard deviations
  std::map<int, PoseBlock> blocks_;  // nodes stay where they are
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace

int PoseGraph::addPose(const Eigen::Isometry3d& T_map_pose) {
  T_map_poses_.push_back(T_map_pose);
  constraints_at_.emplace_back();
  return size() - 1;
}

int PoseGraph::addConstraint(const PoseConstraint& constraint) {
  const auto exists = [&](int pose) { return pose >= 0 && pose < size(); };
  std::string error = constraintError(constraint);
  if (!exists(constraint.from) || !exists(constraint.to)) error = "there is no such pose";
  if (!error.empty()) {
    throw std::invalid_argument("constraint from pose " + std::to_string(constraint.from) +
                                " to pose " + std::to_string(constraint.to) + ": " + error);
  }
  const auto index = static_cast<int>(constraints_.size());
  constraints_.push_back(constraint);
  const Matrix6d covariance = invertSymmetric(constraint.information);
  steps_.push_back(
      {covariance, invertedCovariance(constraint.T_from_to, covariance), lengthOf(covariance)});
  constraints_at_[constraint.from].push_back(index);
  constraints_at_[constraint.to].push_back(index);
  return index;
}

double PoseGraph::robustWeight(const PoseConstraint& constraint) const {
  if (!constraint.enabled) return 0.0;
  if (constraint.kind == ConstraintKind::kOdometry) return 1.0;
  const double chi2 = constraintChi2(constraint, pose(constraint.from), pose(constraint.to));
  return 1.0 / (1.0 + chi2 / (options_.robust_width * options_.robust_width));
}

OptimizeReport PoseGraph::solve(const std::vector<int>& free) {
  Problem problem(*this, free);
  OptimizeReport report = problem.solve(options_.max_iterations);
  report.poses = static_cast<int>(free.size());
  for (const int index : free) T_map_poses_[index] = problem.pose(index);
  return report;
}

OptimizeReport PoseGraph::optimize() {
  OptimizeReport total;
  if (size() < 2) return total;
  std::vector<int> free(size() - 1);
  std::iota(free.begin(), free.end(), 1);
  for (int review = 0; review < kMaxReviews; ++review) {
    const OptimizeReport report = solve(free);
    const double initial_cost = review == 0 ? report.initial_cost : total.initial_cost;
    const int iterations = total.iterations + report.iterations;
    const int64_t evaluations = total.residual_evaluations + report.residual_evaluations;
    total = report;
    total.initial_cost = initial_cost;
    total.iterations = iterations;
    total.residual_evaluations = evaluations;
    if (reviewRegistrations() == 0) break;
  }
  total.retired = static_cast<int>(std::count_if(constraints_.begin(), constraints_.end(),
                                                 [](const auto& c) { return !c.enabled; }));
  return total;
}

OptimizeReport PoseGraph::optimizeAround(const std::vector<int>& seeds, int window) {
  const std::vector<int> free = around(seeds, window);
  if (free.empty()) return {};
  return solve(free);
}

int PoseGraph::reviewRegistrations() {
  int changes = 0;
  for (PoseConstraint& constraint : constraints_) {
    if (constraint.kind != ConstraintKind::kRegistration) continue;
    const double chi2 = constraintChi2(constraint, pose(constraint.from), pose(constraint.to));
    const bool agrees = chi2 <= options_.retire_chi2;
    changes += agrees != constraint.enabled ? 1 : 0;
    constraint.enabled = agrees;
  }
  return changes;
}

std::vector<int> PoseGraph::around(const std::vector<int>& seeds, int window) const {
  std::vector<int> found;
  std::vector<int> queue;
  // Not an array over all poses: time must not grow with them.
  std::map<int, bool> seen;
  const auto reach = [&](int pose) {
    if (seen.emplace(pose, true).second) queue.push_back(pose);
  };
  for (const int seed : seeds) reach(seed);
  for (std::size_t next = 0; next < queue.size(); ++next) {
    if (static_cast<int>(found.size()) >= window) break;
    const int pose = queue[next];
    if (pose != 0) found.push_back(pose);
    for (const int index : constraints_at_.at(pose)) {
      const PoseConstraint& constraint = constraints_[index];
      if (constraint.enabled) reach(constraint.from == pose ? constraint.to : constraint.from);
    }
  }
  return found;
}

std::vector<TreeNode> PoseGraph::treeFrom(int root) const {
  // Dijkstra's method on scalars; covariances only along the paths that it leaves.
  std::vector<TreeNode> tree(size());
  std::vector<bool> done(size(), false);
  std::vector<int> by(size(), -1);  // the constraint that leads to a pose
  std::vector<double> best(size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;  // ties go to the lower index
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  tree.at(root).hops = 0;
  best[root] = 0.0;
  queue.emplace(0.0, root);
  while (!queue.empty()) {
    const int a = queue.top().second;
    queue.pop();
    if (done[a]) continue;
    done[a] = true;
    if (a != root) extendTree(by[a], a, &tree);
    for (const int index : constraints_at_[a]) {
      const PoseConstraint& constraint = constraints_[index];
      const int b = constraint.from == a ? constraint.to : constraint.from;
      const double length = best[a] + steps_[index].length;
      if (!constraint.enabled || done[b] || length >= best[b]) continue;
      best[b] = length;
      by[b] = index;
      queue.emplace(length, b);
    }
  }
  return tree;
}

void PoseGraph::extendTree(int constraint, int pose, std::vector<TreeNode>* tree) const {
  const bool forward = constraints_[constraint].to == pose;
  const int parent = forward ? constraints_[constraint].from : constraints_[constraint].to;
  const Matrix6d& step = forward ? steps_[constraint].forward : steps_[constraint].backward;
  const TreeNode& before = (*tree)[parent];
  (*tree)[pose] = {parent, before.hops + 1,
                   composedCovariance(before.covariance, relative(parent, pose), step)};
}

}  // namespace ladar_perception
