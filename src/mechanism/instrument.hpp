// A sensor of a scene. Each kind is a file of instruments/, listed here once.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// What a field does not belong to, it is not read for.
struct Instrument {
  enum class Kind {
    accelerometer,  ///< m/s², of a body's centre of mass along an axis of the world, through a low-pass
    lvdt,           ///< m, position of a body's centre of mass along an axis of the world
    encoder,        ///< rad, angle of a joint
    load_cell,      ///< N, force of a joint on its second body along an axis of the world, through a low-pass
    torque          ///< N m, torque of a drive, through a low-pass
  };
  Kind kind = Kind::accelerometer;
  std::string name;
  int body = ground;
  std::array<int, 2> pair{ground, ground};  ///< encoder: the joint's bodies
  int joint = -1;                           ///< encoder and load cell: index of the joint
  std::string drive;                        ///< torque: name of the drive
  Vec2 axis{1, 0};                          ///< unit vector
  double bandwidth = 0;                     ///< Hz, −3 dB
  int order = 2;                            ///< of the Butterworth low-pass, 1 to 8
  double sampling = 0;                      ///< Hz
  std::optional<double> noise = {};         ///< standard deviation of a sample, in the channel's unit
  unsigned seed = 1;                        ///< of the noise
  std::optional<double> range = {};         ///< ± full scale; samples are kept within
  std::optional<double> resolution = {};    ///< step of the samples, rounded down; an encoder's is 2π/counts
};

/// What a sensor looks at.
enum class Sensing {
  velocity,  ///< its measure of the velocities, whose rate passes the low-pass
  force,     ///< its measure of the forces that come out, which passes the low-pass
  position   ///< its measure of the positions, sample by sample
};

}  // namespace freeplay
