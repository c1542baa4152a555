// The motion of a run or a comparison as a film: frames at equal steps of time, SVG each, and out of them MP4 or GIF by ffmpeg.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay::report {

struct FilmOptions {
  bool mp4 = false, gif = false, svg = false;  ///< none: MP4 where ffmpeg is, else SVG
  double fps = 25;                             ///< frames a second of the film
  std::optional<double> speed =
      {};  ///< seconds of the run in one of the film; left out: the film takes some 20 s
  std::optional<double> from = {}, until = {};  ///< s of the run; left out: all of it
  int width = 960;                              ///< px
  bool over = false;                            ///< both runs over one another
};

struct Film {
  std::vector<std::filesystem::path> files;  ///< of the frames the first
  std::size_t frames = 0;
  double from = 0, until = 0, speed = 0;
  int width = 0, height = 0;    ///< px
  bool without_ffmpeg = false;  ///< frames in place of a film, which nobody asked for
};

inline constexpr std::size_t most_frames = 20'000;

/// Of the result folder of a run or a comparison; the files replace those that an earlier film left in `place`. `progress`: the part
/// that is done. Throws SceneError for what is no such folder and for times that the run does not have, OutputError, and
/// Interrupted when asked to stop.
Film make_film(const std::filesystem::path& folder, const std::filesystem::path& place,
               const FilmOptions& asked, StopToken stop, const std::function<void(double)>& progress);

}  // namespace freeplay::report
