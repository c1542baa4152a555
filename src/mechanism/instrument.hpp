// Facts of a sensor of a scene. A sensor measures one quantity at a sampling rate, with an optional
// low-pass, noise and quantisation (model: simulation/instrument.hpp). The measured quantity and
// the keys of each kind are in a file of dynamics/instruments/.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// A field that a kind does not use is not read.
struct Instrument {
  /// Measured quantity.
  enum class Kind {
    /// m/s², of a body's centre of mass along an axis of the world, through a low-pass
    accelerometer,
    lvdt,     ///< m, position of a body's centre of mass along an axis of the world
    encoder,  ///< rad, angle of a joint
    /// N, force of a joint on its second body along an axis of the world, through a low-pass
    load_cell,
    torque,        ///< N m, torque of a drive, through a low-pass
    strain_gauge,  ///< strain of a beam, through a low-pass
  };
  /// measured quantity
  Kind kind = Kind::accelerometer;
  /// of the instrument in the scene, and its column in the results
  std::string name;
  /// index into Mechanism::bodies
  int body = ground;
  std::array<int, 2> pair{ground, ground};  ///< encoder: bodies of the joint
  int joint = -1;                           ///< encoder and load cell: index of the joint
  std::string drive;                        ///< torque: name of the drive
  std::string beam, element;                ///< strain gauge: name of the beam, and of the element there
  double place = 0, offset = 0;             ///< m, strain gauge: along the beam, and from the neutral axis
  double axial = 1, bending = 1;            ///< N and N m², strain gauge: EA and EI of the section
  Vec2 axis{1, 0};                          ///< unit vector
  double bandwidth = 0;                     ///< Hz, −3 dB
  int order = 2;                            ///< order of the Butterworth low-pass, 1 to 8
  double sampling = 0;                      ///< Hz
  /// Standard deviation of a sample, in the channel's unit.
  std::optional<double> noise = {};
  unsigned seed = 1;                 ///< of the noise
  std::optional<double> range = {};  ///< ± full scale; samples are clipped to it
  /// Quantisation step of the samples, rounded down; 2π/counts for an encoder.
  std::optional<double> resolution = {};
};

/// Quantity that a sensor measures.
enum class Sensing {
  velocity,  ///< a function of the velocities, whose rate passes through the low-pass
  force,     ///< a function of the resulting forces, which passes through the low-pass
  position   ///< a function of the positions, sampled directly
};

}  // namespace freeplay
