// FilmStatistics: quantities of journal bearings over a run. Time means are integrals over the
// dense output by Gauss's rule with three points a step; extremes are those of these points and of
// the ends of the steps.
//
// The law of a film belongs to the formulations, so that this observer asks a FilmProbe
// (film_probe() in formulations/contact/steady_film.hpp) for the films of a state:
//
//     FilmStatistics films(film_probe(scene), scene.run.discard);
//     auto result = simulation.run({.observers = {&films}});
//     films.into(result);
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "simulation/observer.hpp"
#include "values/result.hpp"

namespace freeplay {

/// A film at one state of the mechanism.
struct FilmState {
  double ratio = 0;      ///< ε
  double thickness = 0;  ///< m, least film thickness: the gap
  double load = 0;       ///< N, magnitude of the film force
  double attitude = 0;   ///< rad, from the load to the line of centres, along ω_i + ω_j
  double speed = 0;      ///< rad/s, |ω_i + ω_j|
  double loss = 0;       ///< W
};

/// Evaluates the films of a mechanism at any state.
class FilmProbe {
 public:
  virtual ~FilmProbe() = default;
  /// Names of the lubricated joints, in the scene's order.
  virtual std::vector<std::string> joints() const = 0;
  /// Notes on films outside their range.
  virtual std::vector<std::string> notes() const = 0;
  /// Fills one entry for each of joints().
  virtual void evaluate(double t, std::span<const double> q, std::span<const double> v,
                        std::span<FilmState> out) = 0;
  /// Sommerfeld number of a load (N) and a speed (rad/s).
  virtual double sommerfeld(std::size_t film, double load, double speed) const = 0;
};

class FilmStatistics final : public Observer {
 public:
  /// `discard` (s): excluded start.
  FilmStatistics(std::unique_ptr<FilmProbe> probe, double discard);

  /// Writes the notes on the films, and ContactSummary::film of each lubricated joint unless the run ended
  /// before `discard`.
  void into(Result& result) const;

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override { m(tallies_, time_); }
  void load(MemoryReader& m) override { m(tallies_, time_); }

 private:
  /// Integrals over time, and extremes.
  struct Tally {
    double ratio = 0, thickness = 0, load = 0, speed = 0, loss = 0, cosine = 0, sine = 0;
    double greatest_ratio = 0, least_thickness = 0, least_at = 0, greatest_load = 0, greatest_loss = 0;
    bool any = false;
    void add(const FilmState& s, double seconds);
    void compare(const FilmState& s, double t);
    template <class M>
    void serialize(M& m) {
      m(ratio, thickness, load, speed, loss, cosine, sine, greatest_ratio, least_thickness, least_at,
        greatest_load, greatest_loss, any);
    }
  };
  void evaluate(const Step& step, double t);

  std::unique_ptr<FilmProbe> probe_;
  double discard_, time_ = 0;  // s
  std::vector<Tally> tallies_;
  std::vector<FilmState> now_;
  std::vector<double> q_, v_;
};

}  // namespace freeplay
