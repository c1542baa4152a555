#include "own.hpp"

#include "io/files/digest.hpp"
#include "io/files/visible.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// A Python function owned by a law. A law may be destroyed in any thread, so the destructor
/// acquires the interpreter lock.
struct Function {
  explicit Function(py::function called) : f(std::move(called)) {}
  Function(const Function&) = delete;
  Function& operator=(const Function&) = delete;
  ~Function() {
    const py::gil_scoped_acquire locked;
    f = py::function();
  }
  py::function f;
};

double call(const void* context, const char* contact, double delta, double rate, double v0) {
  const py::gil_scoped_acquire locked;  // a run does not hold the lock
  return py::float_(static_cast<const Function*>(context)->f(contact, delta, rate, v0));
}

Vec2 call(const void* context, const char* load, double t, const Vec2& place, const Vec2& velocity) {
  const py::gil_scoped_acquire locked;
  const py::object found = static_cast<const Function*>(context)->f(
      t, py::make_tuple(place.x(), place.y()), py::make_tuple(velocity.x(), velocity.y()));
  if (!py::isinstance<py::sequence>(found) || py::len(found) != 2)
    throw py::type_error("the force of " + std::string(load) + " must be two numbers (N), is " +
                         std::string(py::repr(found)));
  const auto f = py::reinterpret_borrow<py::sequence>(found);
  return {py::float_(f[0]), py::float_(f[1])};
}

template <class Own>
std::shared_ptr<const Own> own_of(decltype(Own::force) force, const py::function& f, const std::string& name,
                                  const std::string& what) {
  return std::make_shared<const Own>(
      Own{force, std::make_shared<Function>(f), visible_brief(name), digest(what)});
}

}  // namespace

std::shared_ptr<const OwnLaw> law_of(const py::function& f, const std::string& name,
                                     const std::string& what) {
  return own_of<OwnLaw>(call, f, name, what);
}

std::shared_ptr<const OwnForce> force_of(const py::function& f, const std::string& name,
                                         const std::string& what) {
  return own_of<OwnForce>(call, f, name, what);
}

}  // namespace freeplay::python
