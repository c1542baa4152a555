#include "plots/film/film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/child.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "mechanism/error.hpp"
#include "plots/film/film_drawing.hpp"
#include "plots/film/wear_drawing.hpp"

namespace freeplay::report {
namespace {

using Path = std::filesystem::path;

constexpr double usual_length = 20;  // s
constexpr double rounding = 1e-9;    // fraction of a frame

std::vector<FilmRun> runs_of(const Path& folder) {
  auto folders = plots::runs_in(folder);
  if (folders.empty())
    throw SceneError(folder.string() +
                     ": contains no run to animate; give a folder made by freeplay run, compare or orbit");
  // What a comparison is about are the two loose runs.
  if (folders.size() > 1) std::erase_if(folders, [](const auto& run) { return run.title == "ideal joint"; });
  std::vector<FilmRun> runs;
  for (const auto& run : folders) runs.push_back(film_run(run, 6000));
  return runs;
}

/// The least number ≥ x of the form 1, 2 or 5 times a power of ten.
double round_above(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)));
  return power * (x <= power ? 1 : x <= 2 * power ? 2 : x <= 5 * power ? 5 : 10);
}

/// More are refused with the advice to take fewer rows or images per second.
constexpr std::size_t most_frames = 20'000;

/// Determines start, end, speed and number of frames of the film.
Film plan(const std::vector<FilmRun>& runs, const FilmOptions& requested) {
  double begin = INFINITY, end = -INFINITY;
  for (const auto& run : runs) begin = std::min(begin, run.t.front()), end = std::max(end, run.t.back());
  Film film;
  film.from = requested.from.value_or(begin), film.until = requested.until.value_or(end);
  const auto inside = [&](double t, const char* name) {
    if (t < begin || t > end)
      throw SceneError(fmt::format("{} {:g}: is outside the run, from {:g} to {:g} s", name, t, begin, end));
  };
  if (requested.from) inside(*requested.from, "--from");
  if (requested.until) inside(*requested.until, "--until");
  if (film.until < film.from || (film.until == film.from && requested.until))
    throw SceneError(fmt::format("--until {:g}: must be later than --from {:g}", film.until, film.from));
  const double length = film.until - film.from;
  film.speed = requested.speed.value_or(length > 0 ? round_above(length / usual_length) : 1);
  const double frames = std::floor(length / film.speed * requested.fps + rounding) + 1;
  if (frames > static_cast<double>(most_frames))
    throw SceneError(
        fmt::format("{:.0f} frames, more than {}: use a greater --speed, a smaller --fps, or a part with "
                    "--from and --until",
                    frames, most_frames));
  film.frames = static_cast<std::size_t>(frames);
  return film;
}

std::string name_of(std::size_t frame) { return fmt::format("frame_{:06}.svg", frame + 1); }

/// The SVG of frame k.
using FrameOf = std::function<std::string(std::size_t k)>;

void draw_frames(const FrameOf& frame, const Film& film, const Path& place, StopToken stop,
                 const std::function<void(double)>& progress) {
  for (std::size_t k = 0; k < film.frames; ++k) {
    if (stop()) throw Interrupted();
    write_file(place / name_of(k), frame(k));
    progress(static_cast<double>(k + 1) / static_cast<double>(film.frames));
  }
}

bool has_ffmpeg(StopToken stop) {
  return run_child(
             {.command = {"ffmpeg", "-nostdin", "-hide_banner", "-version"}, .seconds = 20, .stop = stop})
             .status == 0;
}

/// Runs ffmpeg in `place`. `how`: the options between the names of the frames and the file, which
/// are fixed.
void encode(const Path& place, const FilmOptions& requested, const Film& film, std::vector<std::string> how,
            const std::string& file, StopToken stop) {
  std::vector<std::string> command{
      "ffmpeg",        "-nostdin", "-hide_banner", "-loglevel",
      "error",         "-y",       "-framerate",   fmt::format("{:.6g}", requested.fps),
      "-start_number", "1",        "-i",           "frame_%06d.svg"};
  command.insert(command.end(), how.begin(), how.end());
  // Identical frames give identical bytes.
  for (const char* word : {"-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"})
    command.emplace_back(word);
  command.push_back(file);
  const double longest = 60 + 2 * static_cast<double>(film.frames);
  const auto end =
      run_child({.command = std::move(command), .folder = place, .seconds = longest, .stop = stop});
  if (end.late)
    throw OutputError(fmt::format("ffmpeg took longer than {:.0f} s for {} and was stopped", longest, file));
  if (end.status == 127) throw OutputError("ffmpeg cannot be started");
  if (end.status != 0)
    throw OutputError(fmt::format("ffmpeg made no {} (status {}): {}", file, end.status,
                                  end.errors.substr(0, end.errors.find('\n'))));
}

}  // namespace

namespace {

/// The requested files; without a request MP4 if ffmpeg exists, else SVG.
FilmOptions with_files(FilmOptions options, Film& film, StopToken stop) {
  if (!options.mp4 && !options.gif && !options.svg) {
    options.mp4 = has_ffmpeg(stop);
    options.svg = film.without_ffmpeg = !options.mp4;
  } else if ((options.mp4 || options.gif) && !has_ffmpeg(stop)) {
    throw SceneError(
        fmt::format("{}: ffmpeg is not installed (Debian: apt install ffmpeg); --svg works "
                    "without it",
                    options.mp4 ? "--mp4" : "--gif"));
  }
  return options;
}

/// Draws and encodes the frames of a film in `place`.
Film made(Film film, const FrameOf& frame, const Path& place, const FilmOptions& options, StopToken stop,
          const std::function<void(double)>& progress) {
  ResultSet set(place, "animate");
  draw_frames(frame, film, set.place(), stop, progress);
  if (options.mp4) {
    encode(set.place(), options, film, {"-c:v", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart"},
           "animation.mp4", stop);
    film.files.push_back(place / "animation.mp4");
  }
  if (options.gif) {
    encode(set.place(), options, film,
           {"-filter_complex", "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse", "-loop", "0"},
           "animation.gif", stop);
    film.files.push_back(place / "animation.gif");
  }
  if (options.svg)
    film.files.push_back(place / name_of(0));
  else
    for (std::size_t k = 0; k < film.frames; ++k) remove_file(set.place() / name_of(k));
  set.commit();
  return film;
}

/// The film of a wear study, of about `wear_length` seconds.
Film make_wear_film(const Path& folder, const Path& place, const FilmOptions& requested, StopToken stop,
                    const std::function<void(double)>& progress) {
  if (requested.speed || requested.from || requested.until || requested.over || requested.magnify != 1)
    throw SceneError(
        "--speed, --from, --until, --over, --magnify: are not those of a film of wear, which shows all turns");
  constexpr double wear_length = 8;  // s
  const WearDrawing drawing(folder, requested.width);
  Film film;
  film.until = drawing.turns(), film.of_turns = true;
  film.width = drawing.width(), film.height = drawing.height();
  film.frames = static_cast<std::size_t>(wear_length * requested.fps) + 1;
  const auto options = with_files(requested, film, stop);
  const auto frame = [&](std::size_t k) {
    return drawing.frame(film.until * static_cast<double>(k) / static_cast<double>(film.frames - 1));
  };
  return made(film, frame, place, options, stop, progress);
}

}  // namespace

Film make_film(const Path& folder, const Path& place, const FilmOptions& requested, StopToken stop,
               const std::function<void(double)>& progress) {
  if (std::filesystem::exists(folder / "wear.json"))
    return make_wear_film(folder, place, requested, stop, progress);
  const auto runs = runs_of(folder);
  auto film = plan(runs, requested);
  if (requested.magnify != 1 &&
      std::ranges::all_of(runs, [](const FilmRun& r) { return r.beams.empty() && !r.has_surfaces(); }))
    throw SceneError(
        "--magnify: the mechanism has neither beams nor profiles, whose deflection and deviations it magnifies");
  const auto options = with_files(requested, film, stop);
  const JsonFile first(plots::runs_in(folder).front().folder / "run.json");
  const auto* given = first.find("provenance.title");
  const auto title = given && given->is_string() ? given->get<std::string>() : folder.filename().string();
  const FilmDrawing drawing(
      runs, {.title = title, .width = options.width, .over = options.over, .magnify = options.magnify});
  film.width = drawing.width(), film.height = drawing.height();
  const double step = film.speed / options.fps;
  const auto frame = [&](std::size_t k) {
    return drawing.frame(std::min(film.from + static_cast<double>(k) * step, film.until), 0.5 * step);
  };
  return made(film, frame, place, options, stop, progress);
}

}  // namespace freeplay::report
