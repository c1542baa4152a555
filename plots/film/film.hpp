// The motion of a run or a comparison as a film: SVG frames at equal time steps, from which ffmpeg
// makes MP4 or GIF. Likewise the worn surfaces of a wear study, at equal steps of turns.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay::report {

struct FilmOptions {
  bool mp4 = false, gif = false, svg = false;  ///< none set: MP4 if ffmpeg exists, else SVG
  double fps = 25;                             ///< frames per second of the film
  /// seconds of the run per second of film; absent: a film of about 20 s
  std::optional<double> speed = {};
  std::optional<double> from = {}, until = {};  ///< s of the run; absent: the whole run
  int width = 960;                              ///< px
  bool over = false;                            ///< both runs in one panel
  double magnify = 1;  ///< factor of the deflection of beams, of clearance and deviations of surfaces
};

struct Film {
  std::vector<std::filesystem::path> files;  ///< of SVG frames only the first
  std::size_t frames = 0;
  double from = 0, until = 0, speed = 0;
  int width = 0, height = 0;    ///< px
  bool of_turns = false;        ///< from and until are numbers of turns, of a wear study
  bool without_ffmpeg = false;  ///< frames instead of a film, because ffmpeg is missing
};

/// Makes the film of a run, a comparison or a wear study from its result folder. The files replace those of an
/// earlier film in `place`. `progress` is called with the completed fraction. Throws SceneError for
/// other folders and for times outside the run, OutputError, and Interrupted on a stop request.
Film make_film(const std::filesystem::path& folder, const std::filesystem::path& place,
               const FilmOptions& requested, StopToken stop, const std::function<void(double)>& progress);

}  // namespace freeplay::report
