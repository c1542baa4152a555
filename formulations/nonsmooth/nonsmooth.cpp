#include "formulations/nonsmooth/nonsmooth.hpp"

#include <fmt/format.h>

#include "formulations/nonsmooth/moreau.hpp"
#include "sim/march.hpp"

namespace freeplay {
namespace {

class Nonsmooth final : public Formulation {
 public:
  Nonsmooth(const Scene& scene, const System& system, const State& state, std::vector<double> restitution)
      : scene_(scene),
        system_(system),
        restitution_(std::move(restitution)),
        stepper_(system, scene.nonsmooth, restitution_, !redundant_rows(system, state.q).empty()) {
    start(state);
  }
  const char* name() const override { return "nonsmooth"; }
  void start(const State& state) override {
    log_ = ContactLog(system_.contacts(), scene_.run.discard);
    stepper_.start(state, log_);
    initial_ = system_.kinetic(state.v.data()) + system_.potential(state.q.data());
  }
  Ending run(double t_end, Recorder& recorder) override {
    auto ending = march(stepper_, t_end, log_, recorder);
    log_.tally_until(stepper_.t());
    log_.drain([&](const ContactEvent& e) { recorder.event(e); });
    return ending;
  }
  State state() const override {
    return {stepper_.t(), stepper_.q(), {stepper_.v(), stepper_.v() + system_.n()}};
  }
  EnergyLedger ledger() const override {
    EnergyLedger l = stepper_.integrals();
    l.initial = initial_;
    l.kinetic = system_.kinetic(stepper_.v());
    l.potential = system_.potential(stepper_.q().data());
    return l;
  }
  const Work& work() const override { return stepper_.work(); }
  const Extremes& extremes() const override { return stepper_.extremes(); }
  const ContactLog& log() const override { return log_; }
  std::vector<ContactModel> contact_models() const override {
    std::vector<ContactModel> models;
    for (int k = 0; k < system_.contacts(); ++k)
      models.push_back({*system_.contact_facts(k).surface.restitution, restitution_[k], 0, 0, 0});
    return models;
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (stepper_.singular())
      notes.push_back("constraint rows depend on each other: reactions are those of least norm");
    return notes;
  }

 private:
  const Scene& scene_;
  const System& system_;
  std::vector<double> restitution_;
  MoreauStepper stepper_;
  ContactLog log_;
  double initial_ = 0;
};

}  // namespace

std::unique_ptr<Formulation> make_nonsmooth(const Scene& scene, const System& system, const State& state,
                                            const std::vector<double>& restitution) {
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).lubricant)
      throw SceneError(fmt::format(
          "{}: joints.{}.lubricant: the nonsmooth formulation has no film; leave it out, or use the "
          "penalty formulation",
          scene.file.string(), system.contact_facts(k).name));
  std::vector<double> e = restitution;
  for (int k = static_cast<int>(e.size()); k < system.contacts(); ++k) {
    const auto& surface = system.contact_facts(k).surface;
    if (!surface.restitution)
      throw SceneError(fmt::format("{}: surfaces.{}.restitution: is missing: an impact law needs it",
                                   scene.file.string(), surface.name));
    e.push_back(*surface.restitution);
  }
  return std::make_unique<Nonsmooth>(scene, system, state, std::move(e));
}

}  // namespace freeplay
