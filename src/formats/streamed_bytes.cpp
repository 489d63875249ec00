#include "formats/streamed_bytes.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

namespace loopstone {

/// The stream, and what was looked at.
class StreamedBytes::Kept {
 public:
  Kept(std::unique_ptr<ByteStream> stream, std::optional<double> look_s)
      : stream_(std::move(stream)), look_s_(look_s) {}

  [[nodiscard]] const std::string& name() const { return stream_->name(); }

  /// Copies from the kept bytes at a position, or else takes new ones from the stream. Nothing:
  /// there are none yet.
  std::optional<std::size_t> read(std::size_t position, std::span<char> buffer, bool keep) {
    if (position < bytes_.size()) {
      const std::size_t count = std::min(buffer.size(), bytes_.size() - position);
      std::memcpy(buffer.data(), bytes_.data() + position, count);
      return count;
    }
    if (!keep) std::vector<char>().swap(bytes_);  // all of it was read, and nobody comes after
    if (keep && has_looked_enough()) return 0;
    const auto count = stream_->take(buffer);
    if (!count || *count == 0) return count;
    if (!first_) first_ = Clock::now();
    if (keep)
      bytes_.insert(bytes_.end(), buffer.begin(), buffer.begin() + static_cast<long>(*count));
    return count;
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool has_looked_enough() const {
    return look_s_ && first_ && Clock::now() - *first_ > std::chrono::duration<double>(*look_s_);
  }

  std::unique_ptr<ByteStream> stream_;
  std::optional<double> look_s_;
  std::optional<Clock::time_point> first_{};  ///< when bytes came first
  std::vector<char> bytes_{};
};

namespace {

class StreamSource final : public ByteSource {
 public:
  StreamSource(std::shared_ptr<StreamedBytes::Kept> stream, bool keep)
      : stream_(std::move(stream)), keep_(keep) {}

  std::size_t read(std::span<char> buffer) override {
    while (true) {
      if (const auto count = read_now(buffer)) return *count;
    }
  }
  std::optional<std::size_t> read_now(std::span<char> buffer) override {
    const auto count = stream_->read(done_, buffer, keep_);
    done_ += count.value_or(0);
    return count;
  }
  std::int64_t bytes_done() const override { return static_cast<std::int64_t>(done_); }
  std::int64_t bytes_total() const override { return 0; }  // not known

 private:
  std::shared_ptr<StreamedBytes::Kept> stream_;
  bool keep_;
  std::size_t done_ = 0;
};

}  // namespace

StreamedBytes::StreamedBytes(std::unique_ptr<ByteStream> stream, std::optional<double> look_s)
    : kept_(std::make_shared<Kept>(std::move(stream), look_s)) {}

const std::string& StreamedBytes::name() const { return kept_->name(); }

std::unique_ptr<ByteSource> StreamedBytes::look() const {
  return std::make_unique<StreamSource>(kept_, true);
}

std::unique_ptr<ByteSource> StreamedBytes::read() const {
  return std::make_unique<StreamSource>(kept_, false);
}

}  // namespace loopstone
