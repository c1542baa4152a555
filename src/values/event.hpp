// Contact events: the lines of events.csv. ContactLog makes them from contact onsets and
// separations, and observers receive them.
//
//     impact        a contact shorter than the limit of the formulation, with its impulse
//     contact       the beginning of a lasting contact
//     separation    the end of a lasting contact, with its impulse and duration
#pragma once

#include <array>
#include <string>

namespace freeplay {

/// Kind of a contact event, as above.
enum class EventKind { impact, contact, separation };
/// The word of events.csv.
const char* name_of(EventKind kind);

/// An event of the contact with this index.
struct ContactEvent {
  double t = 0;  ///< s, of contact onset; for a separation, of its instant
  /// index into Layout::contacts, or a family
  int contact = 0;
  /// kind of the event
  EventKind kind = EventKind::impact;
  double crank_angle = 0;               ///< rad, at t
  double v_n_minus = 0, v_n_plus = 0;   ///< m/s, rate of the gap before and after
  double v_t_minus = 0, v_t_plus = 0;   ///< m/s, sliding rate before and after
  double impulse_n = 0, impulse_t = 0;  ///< N s
  double duration = 0;                  ///< s, of the contact
  double t_uncertainty = 0;             ///< s
  /// Bodies of a pair of a family, whose index is then `contact`; else −1.
  std::array<int, 2> bodies{-1, -1};

  template <class M>
  void serialize(M& m) {
    m(t, contact, kind, crank_angle, v_n_minus, v_n_plus, v_t_minus, v_t_plus, impulse_n, impulse_t, duration,
      t_uncertainty, bodies);
  }
};

/// A ContactEvent with the name of the contact in the scene: that of its joint, or its own.
struct Event : ContactEvent {
  /// name of the contact
  std::string joint;

  template <class M>
  void serialize(M& m) {
    ContactEvent::serialize(m);
    m(joint);
  }
};

}  // namespace freeplay
