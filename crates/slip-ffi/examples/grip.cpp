// A control loop of 1 kHz in C++17: each sample leads to a force. The gripper is a toy: its object slips until it is
// held by 5 N.
#include <slip.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <new>
#include <random>
#include <stdexcept>
#include <string>

/// A pipeline with a controller, in memory of its own.
class Grip {
 public:
  explicit Grip(float rate_hz) : memory_(new std::byte[slip_size()]) {
    slip_options options{};
    options.rate_hz = rate_hz;
    options.control = 1;
    char why[200] = "";
    const slip_status status = slip_create(memory_.get(), slip_size(), &options, why, sizeof why, &pipeline_);
    if (status != SLIP_STATUS_OK) throw std::invalid_argument(std::string(slip_error_text(status)) + ": " + why);
  }
  ~Grip() { slip_destroy(pipeline_); }
  Grip(const Grip &) = delete;
  Grip &operator=(const Grip &) = delete;

  /// The force to hold with (N) after this sample.
  float step(float stylus_m, float force_n, float travel_m) noexcept {
    slip_block block{};
    block.rows = 1;
    block.stylus = &stylus_m;
    block.normal_force_n = &force_n;
    block.travel_m = &travel_m;
    slip_result result{};
    // What is refused changes nothing: the force stays.
    if (slip_push(pipeline_, &block, &result) == SLIP_STATUS_OK) {
      state_ = result.state;
      slips_ += state_.scene == SLIP_SCENE_SLIPPING;
    }
    return state_.command_n;
  }
  unsigned slips() const noexcept { return slips_; }

 private:
  std::unique_ptr<std::byte[]> memory_;
  slip_pipeline *pipeline_ = nullptr;
  slip_state state_{};
  unsigned slips_ = 0;
};

int main() {
  Grip grip(1000.0F);
  std::mt19937 random(3000);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  float applied_n = 0.0F, moved_m = 0.0F, command_n = 0.0F;
  for (int at = 0; at < 5000; ++at) {
    applied_n += 0.1F * (command_n - applied_n); // a drive with a lag of 10 ms
    const bool slides = at > 1500 && applied_n < 5.0F;
    if (slides) moved_m += 10e-6F;
    const float stylus_m = (slides ? 5e-6F : 5e-8F) * noise(random);
    command_n = grip.step(stylus_m, applied_n + 0.002F * noise(random), moved_m);
  }
  std::printf("held with %.2f N, moved %.2f mm, %u ms of slip\n", static_cast<double>(applied_n),
              1e3 * static_cast<double>(moved_m), grip.slips());
  return !(applied_n >= 5.0F && moved_m > 0.0F);
}
