// freeplay animate: a film of the motion of a run or a comparison.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

#include "cli/progress.hpp"
#include "cli/verb.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_set.hpp"
#include "mechanism/error.hpp"
#include "plots/film/film.hpp"

namespace freeplay::cli {
namespace {

struct AnimateRequest : Request {
  std::string folder;
  std::string output;
  report::FilmOptions film;
};

int animate(const AnimateRequest& request) {
  const auto folder = real_folder(request.folder);
  if (!std::filesystem::is_directory(folder)) throw SceneError(request.folder + ": is no folder");
  const auto place = request.output.empty() ? folder / "animation" : real_folder(request.output);
  if (place == folder) throw SceneError("-o: the film needs a folder of its own");
  // A folder of another user may be read-only. No process of this user writes there, so no lock is
  // needed.
  std::optional<FolderLock> lock;
  if (access(folder.c_str(), W_OK) == 0) {
    lock.emplace(folder, "animate");
    settle_result_sets(folder);
    settle_run(folder);
  }
  Progress progress;
  const auto film = report::make_film(folder, place, request.film, request.stop,
                                      [&](double part) { progress.show("frames", part); });
  progress.clear();
  if (film.without_ffmpeg)
    fmt::print("frames only: ffmpeg is not there, which makes a film of them (Debian: apt install ffmpeg)\n");
  for (const auto& file : film.files)
    fmt::print("{}: {} frames of {} x {}, t = {:g} to {:g} s at {:g} of the run's speed\n", file.string(),
               film.frames, film.width, film.height, film.from, film.until, film.speed);
  return 0;
}

}  // namespace

void animate_verb(Program& program) {
  auto [options, request] =
      program.verb("animate", "a film of a run or a comparison: MP4, GIF, SVG frames", animate);
  auto& film = request.film;
  options.add("folder", request.folder, "folder made by run or compare").required();
  options.flag("--mp4", film.mp4, "animation.mp4; the default where ffmpeg is there");
  options.flag("--gif", film.gif, "animation.gif");
  options.flag("--svg", film.svg, "frame_000001.svg and so on; needs no ffmpeg");
  options
      .add("--speed", film.speed, "seconds of the run in one of the film; left out: the film takes some 20 s")
      .number([](double x) { return x > 0 && x <= 1e12; }, "must be a number greater than 0")
      .takes("RATIO");
  options.add("--fps", film.fps, "frames a second; default 25")
      .number([](double x) { return x >= 1 && x <= 120; }, "must be a number from 1 to 120")
      .takes("NUMBER");
  options.add("--from", film.from, "where the film begins").takes("SECONDS");
  options.add("--until", film.until, "where it ends").takes("SECONDS");
  options.add("--width", film.width, "of the picture; default 960").between(480, 3840).takes("PIXELS");
  options.flag("--over", film.over, "both runs over one another instead of side by side");
  options.output(request.output, "folder for the film; default animation/ in the folder");
}

}  // namespace freeplay::cli
