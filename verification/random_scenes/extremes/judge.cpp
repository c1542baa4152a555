#include "mechanism/error.hpp"
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/support/apart.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification::random_scenes {

Verdict judge_apart(const Cell& cell, double seconds) {
  const auto work = [&cell] {
    Verdict v;
    try {
      v = cell.assess();
    } catch (const SceneError& e) {
      v = {Outcome::refused, e.what()};
      const std::string here =
          test::source_folder().string() + "/";  // the page must not depend on the machine
      if (v.detail.starts_with(here)) v.detail.erase(0, here.size());
    } catch (const std::exception& e) {
      v = {Outcome::crashed, e.what()};
    }
    return static_cast<char>('0' + static_cast<int>(v.outcome)) + v.detail;
  };
  const auto apart = run_apart(work, seconds);
  if (apart.late) return {Outcome::hung, "no end within its time"};
  if (apart.signal != 0 || apart.said.empty())
    return {Outcome::crashed, "signal " + std::to_string(apart.signal)};
  return {static_cast<Outcome>(apart.said[0] - '0'), apart.said.substr(1)};
}

}  // namespace freeplay::verification::random_scenes
