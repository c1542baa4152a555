// freeplay animate: a film of the motion of a run or a comparison, or of the worn surfaces of a wear study.
#include <fmt/format.h>

#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
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
  const auto folder = named_results(request.folder);
  const auto place = request.output.empty() ? folder / "animation" : real_folder(request.output);
  if (place == folder) throw SceneError("-o: the animation needs a separate folder");
  const auto lock = lock_results(folder, "animate", false);
  Progress progress;
  const auto film = report::make_film(folder, place, request.film, request.stop,
                                      [&](double part) { progress.show("frames", part); });
  progress.clear();
  if (film.without_ffmpeg)
    fmt::print(
        "frames only: ffmpeg, which encodes MP4 and GIF, is not installed (Debian: apt install "
        "ffmpeg)\n");
  for (const auto& file : film.files)
    if (film.of_turns)
      fmt::print("{}: {} frames of {} x {}, {:g} turns\n", file.string(), film.frames, film.width,
                 film.height, film.until);
    else
      fmt::print("{}: {} frames of {} x {}, t = {:g} to {:g} s at {:g} times real time\n", file.string(),
                 film.frames, film.width, film.height, film.from, film.until, film.speed);
  return 0;
}

}  // namespace

void animate_verb(Program& program) {
  auto [options, request] =
      program.verb("animate", "animate a run or a comparison: MP4, GIF or SVG frames", animate);
  auto& film = request.film;
  options.add("folder", request.folder, "folder made by run, compare, orbit or wear").required();
  options.flag("--mp4", film.mp4, "write animation.mp4; default if ffmpeg is installed");
  options.flag("--gif", film.gif, "animation.gif");
  options.flag("--svg", film.svg, "write frame_000001.svg etc.; needs no ffmpeg");
  options
      .add("--speed", film.speed,
           "simulated seconds per second of animation; default: about 20 s of "
           "animation")
      .number([](double x) { return x > 0 && x <= 1e12; }, "must be a number greater than 0")
      .takes("RATIO");
  options.add("--fps", film.fps, "frames per second; default 25")
      .number([](double x) { return x >= 1 && x <= 120; }, "must be a number from 1 to 120")
      .takes("NUMBER");
  options.add("--from", film.from, "start of the animation").takes("SECONDS");
  options.add("--until", film.until, "end of the animation").takes("SECONDS");
  options.add("--width", film.width, "width of the picture; default 960").between(480, 3840).takes("PIXELS");
  options.flag("--over", film.over, "overlay both runs instead of showing them side by side");
  options
      .add("--magnify", film.magnify,
           "factor of the deflection of beams, and of clearance and deviations of "
           "joints with profiles; default 1")
      .number([](double x) { return x > 0 && x <= 1e9; }, "must be a number greater than 0, at most 1e9")
      .takes("FACTOR");
  options.output(request.output, "folder for the animation; default animation/ in the input folder");
}

}  // namespace freeplay::cli
