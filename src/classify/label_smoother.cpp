// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/label_smoother.h"

#include <algorithm>

#include "ladar_perception/classify/posterior_sums.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = FeatureBlock::kSize;

template <int kClasses>
class Smoother final : public LabelSmoother {
 public:
  Smoother(const Classifier& classifier, const Calibration& calibration, int threads)
      : LabelSmoother(classifier, calibration),
        box_sums_(threads, SlidingBoxSums<PosteriorSum<kClasses>>(cube(radius()))) {}

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
             std::vector<Classification>* labels) override {
    const PosteriorField<kClasses> field(map, records_.data());
    const std::vector<int> rows = shareRows(map, columns, pool->size());
    pool->run([&](int share) {
      Output output(*this, labels);
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
  /// Turns sums into labels, a block of voxels at a time.
  class Output {
   public:
    Output(const Smoother& smoother, std::vector<Classification>* labels)
        : smoother_(smoother), labels_(*labels) {}

    LADAR_INLINE PosteriorSum<kClasses>& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) {
      if (count_ == kSize) flush();
      slots_[count_] = static_cast<uint32_t>(slot);
      __builtin_prefetch(&labels_[slot], 1);
      return sums_[count_++];
    }

    __attribute__((noinline)) void flush() {
      const Classifier& classifier = smoother_.classifier_;
      const std::size_t classes = classifier.classes();
      dispatch([&]() LADAR_INLINE_LAMBDA {
        for (int i = 0; i < kSize; ++i) {
          const uint32_t total = std::max(sums_[i].count(), uint32_t{1});
          const float by_total = 1.0F / static_cast<float>(static_cast<int32_t>(total));
          for (std::size_t c = 0; c < classes; ++c) {
            const auto part = static_cast<float>(static_cast<int32_t>(sums_[i].part[c]));
            block_.probability[c][i] = part * by_total;
          }
        }
      });
      for (int i = 0; i < count_; ++i) {
        uint32_t own = 0;
        for (const uint16_t part : smoother_.records_[slots_[i]].part) own |= part;
        block_.known[i] = own;
      }
      classifier.sharpen(static_cast<float>(smoother_.calibration_.smoothing_sharpness), &block_);
      Classification chosen[kSize];
      classifier.choose(block_, count_, chosen);
      for (int i = 0; i < count_; ++i) labels_[slots_[i]] = chosen[i];
      count_ = 0;
    }

   private:
    const Smoother& smoother_;
    std::vector<Classification>& labels_;
    int count_ = 0;
    uint32_t slots_[kSize];
    PosteriorSum<kClasses> sums_[kSize];
    PosteriorBlock block_;
  };

  std::vector<PosteriorRecord<kClasses>> records_;                // by slot of the map
  std::vector<SlidingBoxSums<PosteriorSum<kClasses>>> box_sums_;  // one per thread
};

}  // namespace

std::unique_ptr<LabelSmoother> LabelSmoother::make(const Classifier& classifier,
                                                   const Calibration& calibration, int threads) {
  static_assert(kMaxClasses == 16, "the widest sums are for all of them");
  if (classifier.classes() <= 4) {
    return std::make_unique<Smoother<4>>(classifier, calibration, threads);
  }
  if (classifier.classes() <= 8) {
    return std::make_unique<Smoother<8>>(classifier, calibration, threads);
  }
  return std::make_unique<Smoother<16>>(classifier, calibration, threads);
}

}  // namespace ladar_perception
