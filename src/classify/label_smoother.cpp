// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/label_smoother.h"

#include <algorithm>
#include <array>

#include "ladar_perception/classify/posterior_sums.h"
#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = FeatureBlock::kSize;

template <int kClasses>
class Smoother final : public LabelSmoother {
 public:
  using Sum = PosteriorSum<kClasses>;

  Smoother(const Classifier& classifier, const Calibration::Smoothing& smoothing, int threads)
      : LabelSmoother(classifier, smoothing) {
    std::vector<SupportBox> boxes;
    for (const int radius : smoothing.radii_voxels) boxes.push_back(cube(radius));
    for (int i = 0; i < threads; ++i) box_sums_.emplace_back(boxes);
  }

  void resize(std::size_t slots) override { records_.resize(slots); }

  void keep(const PosteriorBlock& block, const uint32_t* slots, int count) override {
    dispatch([&]() LADAR_INLINE_LAMBDA {
      for (int i = 0; i < count; ++i) {
        PosteriorRecord<kClasses> record;
        const float unit = block.known[i] != 0 ? static_cast<float>(kPosteriorUnit) : 0.0F;
        for (std::size_t c = 0; c < classifier_.classes(); ++c) {
          record.part[c] = static_cast<uint16_t>(block.probability[c][i] * unit + 0.5F);
        }
        records_[slots[i]] = record;
      }
    });
  }

  void label(const VoxelMap& map, const ColumnSet& columns, ThreadPool* pool,
             std::vector<Classification>* labels, std::vector<float>* terms) override {
    if (terms != nullptr) terms->resize(records_.size() * termCount());
    const PosteriorField<kClasses> field(map, records_.data());
    const std::vector<int> rows = shareRows(map, columns, pool->size());
    pool->run([&](int share) {
      Output output(*this, labels->data(), terms == nullptr ? nullptr : terms->data());
      box_sums_[share].compute(field, columns, rows[share], rows[share + 1], output);
      output.flush();
    });
  }

  std::size_t memoryBytes() const override {
    std::size_t bytes = records_.capacity() * sizeof(PosteriorRecord<kClasses>);
    for (const auto& box_sums : box_sums_) bytes += box_sums.memoryBytes();
    return bytes;
  }

 private:
  std::size_t termCount() const { return smoothing_.exponents.size() * classifier_.classes(); }

  /// Turns sums into labels, a block of voxels at a time.
  class Output {
   public:
    Output(const Smoother& smoother, Classification* labels, float* terms)
        : smoother_(smoother),
          labels_(labels),
          terms_(terms),
          sums_(smoother.smoothing_.exponents.size()) {}

    LADAR_INLINE void accept(std::size_t slot, int /*x*/, int /*y*/, int /*z*/, const Sum* sums) {
      if (count_ == kSize) flush();
      slots_[count_] = static_cast<uint32_t>(slot);
      __builtin_prefetch(&labels_[slot], 1);
      for (std::size_t i = 1; i < sums_.size(); ++i) sums_[i][count_] = sums[i - 1];
      ++count_;
    }

    __attribute__((noinline)) void flush() {
      if (count_ == 0) return;
      const Classifier& classifier = smoother_.classifier_;
      takeOwn();
      for (std::size_t c = 0; c < classifier.classes(); ++c) multiplyTerms(c);
      classifier.normalize(&block_);
      Classification chosen[kSize];
      classifier.choose(block_, count_, chosen);
      for (int i = 0; i < count_; ++i) labels_[slots_[i]] = chosen[i];
      count_ = 0;
    }

   private:
    void takeOwn() {
      for (int i = 0; i < count_; ++i) {
        const auto& record = smoother_.records_[slots_[i]];
        for (int c = 0; c < kClasses; ++c) sums_[0][i].part[c] = record.part[c];
        block_.known[i] = sums_[0][i].count();
      }
    }

    /// The class's logarithms, with their exponents, into the block.
    void multiplyTerms(std::size_t c) {
      const Calibration::Smoothing& smoothing = smoother_.smoothing_;
      float* __restrict__ log_product = block_.probability[c];
      std::fill_n(log_product, kSize, static_cast<float>(smoothing.offsets[c]));
      for (std::size_t t = 0; t < sums_.size(); ++t) {
        const auto exponent = static_cast<float>(smoothing.exponents[t]);
        const Sum* sums = sums_[t].data();
        float logs[kSize];
        dispatch([&]() LADAR_INLINE_LAMBDA {
          for (int i = 0; i < kSize; ++i) {
            const auto total = static_cast<float>(static_cast<int32_t>(sums[i].count()));
            const auto part = static_cast<float>(static_cast<int32_t>(sums[i].part[c]));
            const float mean = part / std::max(total, 1.0F);
            logs[i] = block_math::logPositive(std::max(mean, kLeastPosterior));
            log_product[i] += exponent * logs[i];
          }
        });
        if (terms_ == nullptr) continue;
        const std::size_t classes = smoother_.classifier_.classes();
        for (int i = 0; i < count_; ++i) {
          terms_[slots_[i] * smoother_.termCount() + t * classes + c] = logs[i];
        }
      }
    }

    const Smoother& smoother_;
    Classification* labels_;
    float* terms_;
    int count_ = 0;
    uint32_t slots_[kSize];
    std::vector<std::array<Sum, kSize>> sums_;  // own, then by radius
    PosteriorBlock block_;
  };

  std::vector<PosteriorRecord<kClasses>> records_;  // by slot of the map
  std::vector<BoxStackSums<Sum>> box_sums_;         // one per thread
};

}  // namespace

LabelSmoother::LabelSmoother(const Classifier& classifier, const Calibration::Smoothing& smoothing)
    : classifier_(classifier), smoothing_(smoothing) {
  smoothing_.offsets.resize(classifier.classes(), 0.0);
}

int LabelSmoother::reach() const {
  return *std::max_element(smoothing_.radii_voxels.begin(), smoothing_.radii_voxels.end());
}

std::unique_ptr<LabelSmoother> LabelSmoother::make(const Classifier& classifier,
                                                   const Calibration::Smoothing& smoothing,
                                                   int threads) {
  static_assert(kMaxClasses == 16, "the widest sums are for all of them");
  if (classifier.classes() <= 4) {
    return std::make_unique<Smoother<4>>(classifier, smoothing, threads);
  }
  if (classifier.classes() <= 8) {
    return std::make_unique<Smoother<8>>(classifier, smoothing, threads);
  }
  return std::make_unique<Smoother<16>>(classifier, smoothing, threads);
}

}  // namespace ladar_perception
