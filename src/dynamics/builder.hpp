// Construction of a System by its elements. The build() of each element's Dynamics calls the
// functions that it needs, for rows, contacts and friction. A Builder refers to the System under
// construction and owns nothing. Links count towards System::longest_arm(); free links do not.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {

class Builder {
 public:
  Builder(System& system, const Mechanism& mechanism) : s_(system), mechanism_(mechanism) {}
  const Mechanism& mechanism() const { return mechanism_; }

  Link link(const std::array<int, 2>& between, const std::array<Vec2, 2>& at);
  Link free_link(const std::array<int, 2>& between, const std::array<Vec2, 2>& at) const {
    return {between[0], between[1], at[0], at[1]};
  }
  /// The bodies of a joint, with its points if it slides, otherwise at their centres of mass.
  Link joint_link(int joint) const {
    const auto& on = mechanism_.joints[joint];
    const auto* slider = std::get_if<TranslationalJoint>(&on);
    return slider ? free_link(slider->between, slider->at) : free_link(bodies_of(on), {});
  }
  double longest_arm() const { return s_.longest_arm_; }
  /// The greatest stated distance of bodies that interact (m); if all are at one point, the
  /// greatest radius of gyration √(J/m) of a body; 1 if all vanish. Planes: along their normal.
  double span() const;
  /// Limits the rotation of any body within a step (rad).
  void limit_turn(double angle) { s_.longest_turn_ = std::min(s_.longest_turn_, angle); }
  /// Adds a length (m) to those considered for the longest arm.
  void reach(double length) { s_.longest_arm_ = std::max(s_.longest_arm_, length); }

  /// @name Constraint rows
  ///@{
  void points(const Link& link, const std::string& name);
  void slide(const Link& link, const Vec2& axis, const std::string& name);
  void distance(const Link& link, double length, const std::string& name);
  void angle(const Link& link, double angle, const std::string& name);
  void reduced_beam(const BeamChord& beam, const std::vector<double>& weights, int modes,
                    const std::string& name);
  void prescribed(const Link& link, double angle, double speed, const std::string& name);
  /// Prescribes the angle, or with `axis` the position along it, as a function of time or, if
  /// `of` ≥ 0, of the angle of joint `of`.
  void motion(const Link& link, const Piecewise& course, const Vec2* axis, int of, const std::string& name);
  /// The straight line y = ratio φ + offset of the angle φ of joint `of`, for the angle or the
  /// position along `axis`.
  void ratio(const Link& link, double ratio, double offset, const Vec2* axis, int of,
             const std::string& name);
  template <class Mesh>
  void mesh(const Link& link, const Mesh& mesh, const std::string& name) {
    s_.rows_.rare = true;
    MeshRow<Mesh> row{link, mesh, s_.rows_.pattern.rows};
    const int bodies[] = {link.i, link.j};
    for (std::size_t k = 0; k < 2; ++k) {
      if (bodies[k] == ground) continue;
      row.first[k] = entry(3 * bodies[k], 0);
      entry(3 * bodies[k] + 1, 0);
      entry(3 * bodies[k] + 2, 0);
    }
    std::get<std::vector<MeshRow<Mesh>>>(s_.rows_.kinds).push_back(row);
    end_row(name, false);
  }
  ///@}

  /// @name Contacts
  ///@{
  ContactFacts facts(const std::string& name, const std::array<int, 2>& between, int surface) const;
  void round(const Link& link, double side, double rest, double radius_i, double radius_j,
             const ContactFacts& facts) {
    pair(RoundPair{link, side, rest, radius_i, radius_j}, facts);
  }
  /// One contact for each arc of a bearing and a journal with profiles.
  void profiled(const Link& link, const OutOfRound& surfaces, ContactFacts facts);
  void line(const Link& link, double side, const Vec2& axis, double rest, double radius,
            const ContactFacts& facts) {
    pair(LinePair{link, side, axis, rest, radius}, facts);
  }
  template <class Mesh>
  void flank(const Link& link, const Mesh& mesh, const ContactFacts& facts) {
    pair(FlankPair<Mesh>{link, mesh}, facts);
  }
  void angle_stop(const AngleStopPair& stop, const ContactFacts& facts) { pair(stop, facts); }
  ///@}

  /// Adds Coulomb friction: along an axis of the first body (SlidingRow), along the surface of a pin
  /// (SpinRow), or of a gear that turns against the line of centres (TurnRow).
  void friction(const FrictionRow& row, FrictionFacts facts);
  /// m, radius at which the relative rotation of two bodies is as inert as their relative translation.
  double gyration(const Link& link) const;
  /// The bound of friction from the constraint rows of an ideal joint.
  ReactionBound reaction_bound(int joint) const;
  /// That from the last row, of a mesh: c for λ in the direction of the force, and in the opposite one.
  ReactionBound mesh_bound(double along, double against) const;

  /// Adds a coordinate at whose kinks steps end. Returns its index in System::phases.
  int phase(Phase phase) {
    s_.curves_.spring_kinks = true;
    s_.curves_.phases.push_back(std::move(phase));
    return s_.phases() - 1;
  }
  /// Adds a contact pair of any kind.
  void pair(const Pair& pair, const ContactFacts& facts);

 private:
  int entry(int column, double constant);
  void end_row(const std::string& name, bool angle);
  void turn_entries(const Link& link);
  /// A row of a motion with its entries; of < 0: against time.
  MotionRow motion_row(const Link& link, const Piecewise& course, const Vec2* axis, int of);

  System& s_;
  const Mechanism& mechanism_;
};

}  // namespace freeplay
