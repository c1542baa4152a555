// The lower limit for the cost of small mechanisms (target freeplay-hand-derived): the rig of
// Flores et al. (2011) with clearance in its gudgeon pin, in two coordinates derived by hand
// (references/loose_slider_crank.hpp), with the same steps as Freeplay.
//
//     Moreau–Jean, θ = ½     y_m = y + (h/2) ẏ;  M (ẏ⁺ − ẏ) = h f + W P at (y_m, t + h/2);
//                            y⁺ = y_m + (h/2) ẏ⁺; a contact that the motion would close by the end
//                            of the step has an impact by Newton's and Coulomb's laws; then y⁺ is
//                            projected along M⁻¹ W_N onto g ≥ 0
//     penalty                one right-hand side with the contact closed: Lankarani and
//                            Nikravesh's force, Ambrósio's friction
//
// Nothing is general here, and no solver of the project is used: one contact, one mechanism, no
// joint reactions, no energy ledger. The output is that of a run of Freeplay for the same motion:
// the events and the same number of rows of a trajectory.
//
//     freeplay-hand-derived nonsmooth DURATION STEP [FOLDER [ROWS]]
//         prints steps, contacts and the last state
//     freeplay-hand-derived penalty CALLS
//         prints calls and a sum
//     freeplay-hand-derived ball DURATION STEP RESTITUTION DROP
//         a ball on a table; prints steps and its height (m)
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "verification/references/loose_slider_crank.hpp"

using namespace freeplay::reference;

namespace {

const LooseSliderCrank<double> rig = [] {
  LooseSliderCrank<double> m;
  m.friction = 0.01;
  return m;
}();
constexpr double restitution = 0.46;

struct Hand {
  double theta = 0, x = 0, w = 0, u = 0, t = 0;  // rod angle, slider position, their rates
  double gap = 0;
};

/// The rows and bias terms of the contact at one configuration.
struct Frame {
  double gap, n_theta, n_x, t_theta, t_x, drive_n, drive_t, gamma_n, gamma_t;
};

struct Event {
  double t, u_n, u_t, p_n, p_t;
};

class Stepper {
 public:
  explicit Stepper(double h) : h_(h) {
    const auto start = ideal_start(rig);
    s.theta = start[0];
    s.w = start[1];
    s.x = start[2];
    s.u = start[3];
    s.gap = rig.clearance;
  }
  Hand s;
  std::vector<Event> events;

  void step(long index) {
    const double r = rig.crank_length, l = rig.rod_length, J = rig.rod_inertia_about_pin(),
                 M = rig.slider_mass;
    const double theta = s.theta + 0.5 * h_ * s.w, x = s.x + 0.5 * h_ * s.u;
    const double t_old = h_ * static_cast<double>(index),
                 phi = rig.start_angle + rig.speed * (t_old + 0.5 * h_);
    const double cp = std::cos(phi), sp = std::sin(phi), ct = std::cos(theta), st = std::sin(theta);
    const double w_free =
        s.w + h_ * rig.rod_mass * rig.rod_centre * r * rig.speed * rig.speed * (sp * ct - cp * st) / J;
    double w = w_free, u = s.u;
    bool pressed = false;
    double p_n = 0, p_t = 0;
    // Vector from bearing to journal, its rate, and the contact frame.
    const double ex = x - r * cp - l * ct, ey = -r * sp - l * st, length = std::sqrt(ex * ex + ey * ey);
    double n_theta = 0, n_x = 0;
    if (length > 1e-9 * rig.clearance) {
      const double nx = ex / length, ny = ey / length, rw = r * rig.speed;
      n_theta = l * (-nx * st + ny * ct), n_x = -nx;
      const double t_theta = -l * (ny * st + nx * ct) - rig.bearing_radius, t_x = -ny;
      const double drive_n = -nx * rw * sp + ny * rw * cp, drive_t = -ny * rw * sp - nx * rw * cp;
      // ë without the terms of θ̈ and ẍ, and the tangential velocity.
      const double ax = r * rig.speed * rig.speed * cp + l * s.w * s.w * ct,
                   ay = r * rig.speed * rig.speed * sp + l * s.w * s.w * st;
      const double vx = s.u + rw * sp + l * s.w * st, vy = -rw * cp - l * s.w * ct;
      const double swirl = -ny * vx + nx * vy, radial = nx * vx + ny * vy;
      const double gamma_n = nx * ax + ny * ay + swirl * swirl / length,
                   gamma_t = ny * ax - nx * ay + swirl * radial / length;
      const double free = n_theta * w + n_x * u + drive_n;
      const double gap = rig.clearance - length;
      if (gap + 0.5 * h_ * (free - 0.25 * h_ * gamma_n) <= 0) {
        const double before = n_theta * s.w + n_x * s.u + drive_n;
        const bool in_impact = steps_ == 0 && -before > 10 * std::abs(0.5 * h_ * gamma_n);
        const double bias_n = in_impact ? 0 : 0.5 * h_ * gamma_n, bias_t = in_impact ? 0 : 0.5 * h_ * gamma_t;
        const double u_n = before + bias_n, b_n = free - bias_n + restitution * u_n,
                     b_t = t_theta * w + t_x * u + drive_t - bias_t;
        if (b_n < 0) {
          const double nn = n_theta * n_theta / J + n_x * n_x / M, nt = n_theta * t_theta / J + n_x * t_x / M,
                       tt = t_theta * t_theta / J + t_x * t_x / M, determinant = nn * tt - nt * nt;
          p_n = (-b_n * tt + b_t * nt) / determinant;
          p_t = (-b_t * nn + b_n * nt) / determinant;
          if (!(p_n >= 0 && std::abs(p_t) <= rig.friction * p_n))
            for (const double way : {1.0, -1.0}) {
              p_n = -b_n / (nn - way * rig.friction * nt);
              p_t = -way * rig.friction * p_n;
              if (way * (b_t + nt * p_n + tt * p_t) >= 0) break;
            }
          w += (n_theta * p_n + t_theta * p_t) / J;
          u += (n_x * p_n + t_x * p_t) / M;
          pressed = p_n > 0;
          if (pressed && steps_++ == 0) {
            const double u_t = t_theta * s.w + t_x * s.u + drive_t + bias_t;
            const double into = u_n < 0 ? std::fmin(std::fmax(-s.gap / u_n, 0), h_) : 0;
            events.push_back({t_old + into, u_n, u_t, 0, 0});
          }
          if (pressed) events.back().p_n += p_n, events.back().p_t += p_t;
        }
      }
    }
    if (!pressed) steps_ = 0;
    s.theta = theta + 0.5 * h_ * w;
    s.x = x + 0.5 * h_ * u;
    s.w = w;
    s.u = u;
    s.t = h_ * static_cast<double>(index + 1);
    s.gap = gap_at(s.t);
    if (s.gap < 0) {  // back along M⁻¹ W_N of the middle
      const double by = -s.gap / (n_theta * n_theta / J + n_x * n_x / M);
      s.theta += by * n_theta / J;
      s.x += by * n_x / M;
      s.gap = gap_at(s.t);
    }
  }

 private:
  double gap_at(double t) const {
    const double phi = rig.start_angle + rig.speed * t;
    const double ex = s.x - rig.crank_length * std::cos(phi) - rig.rod_length * std::cos(s.theta),
                 ey = -rig.crank_length * std::sin(phi) - rig.rod_length * std::sin(s.theta);
    return rig.clearance - std::sqrt(ex * ex + ey * ey);
  }
  double h_;
  int steps_ = 0;
};

int nonsmooth(double duration, double h, const char* folder, long rows) {
  Stepper stepper(h);
  const long steps = std::lround(duration / h), every = rows > 0 ? std::max(1L, steps / rows) : 0;
  std::FILE* table = folder ? std::fopen((std::string(folder) + "/trajectory.csv").c_str(), "w") : nullptr;
  if (table) std::fputs("t,theta,x,omega,vx,gap\n", table);
  for (long i = 0; i < steps; ++i) {
    stepper.step(i);
    const auto& s = stepper.s;
    if (table && (i + 1) % every == 0)
      std::fprintf(table, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", s.t, s.theta, s.x, s.w, s.u, s.gap);
  }
  if (table) {
    std::fclose(table);
    std::FILE* list = std::fopen((std::string(folder) + "/events.csv").c_str(), "w");
    std::fputs("t,v_n_minus,v_t_minus,impulse_n,impulse_t\n", list);
    for (const auto& e : stepper.events)
      std::fprintf(list, "%.17g,%.17g,%.17g,%.17g,%.17g\n", e.t, e.u_n, e.u_t, e.p_n, e.p_t);
    std::fclose(list);
  }
  const auto& s = stepper.s;
  std::printf("%ld %zu %.17g %.17g %.17g %.17g\n", steps, stepper.events.size(), s.theta, s.x, s.w, s.u);
  for (std::size_t i = 0; !folder && i < 3 && i < stepper.events.size(); ++i)
    std::printf("%.12g %.12g\n", stepper.events[i].t, stepper.events[i].u_n);
  return 0;
}

/// Moreau–Jean steps of one coordinate, the gap y; a resting ball has u_N⁻ = 0 within rounding.
int ball(double duration, double h, double e, double drop) {
  constexpr double g = 9.81;
  const long steps = std::lround(duration / h);
  double y = drop, v = 0;
  for (long i = 0; i < steps; ++i) {
    const double middle = y + 0.5 * h * v, free = v - h * g;
    double next = free;
    if (middle + 0.5 * h * free <= 0 && free + e * v < 0) next = -e * v > 0 ? -e * v : 0;
    y = middle + 0.5 * h * next;
    if (y < 0) y = 0;
    v = next;
  }
  std::printf("%ld %.17g\n", steps, y);
  return 0;
}

int penalty(long calls) {
  auto y = ideal_start(rig);
  y[2] += 2.51e-4;  // against the wall
  double sum = 0;
  for (long i = 0; i < calls; ++i) {
    const double t = 1e-7 * static_cast<double>(i);
    const auto k = gudgeon_contact(rig, t, y);
    const double delta = std::fmax(0, k.delta),
                 force = 1.055e11 * delta * std::sqrt(delta) * (1 - 1.66 * k.u_n / 0.5);
    const double share = rig.friction * std::fmin(std::fmax((std::abs(k.u_t) - 1e-4) / (1e-3 - 1e-4), 0), 1);
    const double drag = k.u_t > 0 ? -share * force : share * force;
    const auto r =
        loose_rates(rig, t, y, k.w_n[0] * force + k.w_t[0] * drag, k.w_n[1] * force + k.w_t[1] * drag);
    sum += r[1] + r[3] + force;
  }
  std::printf("%ld %.17g\n", calls, sum);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "";
  if (what == "nonsmooth" && count >= 4)
    return nonsmooth(std::atof(arguments[2]), std::atof(arguments[3]), count > 4 ? arguments[4] : nullptr,
                     count > 5 ? std::atol(arguments[5]) : 36000);
  if (what == "penalty" && count >= 3) return penalty(std::atol(arguments[2]));
  if (what == "ball" && count >= 6)
    return ball(std::atof(arguments[2]), std::atof(arguments[3]), std::atof(arguments[4]),
                std::atof(arguments[5]));
  std::fputs(
      "usage: nonsmooth DURATION STEP [FOLDER [ROWS]] | penalty CALLS | ball DURATION STEP RESTITUTION "
      "DROP\n",
      stderr);
  return 2;
}
