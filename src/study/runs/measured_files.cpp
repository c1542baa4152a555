#include "study/runs/measured_files.hpp"

#include "io/scene/open_scene.hpp"
#include "io/scene/read_section.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

std::shared_ptr<const MeasuredTurns> MeasuredFiles::operator()(const Study& study, const Measure& measure,
                                                               const Scene& scene, double ideal_maximum) {
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0)
    throw error_at(study, {"calibrate"}, "a waveform needs a scene with a drive of prescribed speed");
  // The file is of one crank speed: that of the study's scene with the target's keys.
  const auto own = open_scene(study.scene, measure.overrides, study.reach == Reach::anywhere);
  const auto* measured = main_drive(own->mechanism);
  if (!measured || measured->speed != drive->speed) return nullptr;
  std::promise<Turns> made;
  std::shared_future<Turns> found;
  bool mine = false;
  {
    const std::lock_guard lock(mutex_);
    auto& entry = found_[{measure.digest, drive->speed}];
    mine = !entry.valid();
    if (mine) entry = made.get_future().share();
    found = entry;
  }
  if (mine) try {
      made.set_value(std::make_shared<const MeasuredTurns>(
          turns_of(read_measurement(measure.waveform, drive->speed, ideal_maximum, study.accelerometer),
                   drive->speed)));
    } catch (...) {
      made.set_exception(std::current_exception());
    }
  return found.get();
}

}  // namespace freeplay
