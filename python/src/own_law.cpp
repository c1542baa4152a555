#include "own_law.hpp"

#include "io/digest.hpp"
#include "io/visible.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// Held by laws that end in any thread.
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
  const py::gil_scoped_acquire locked;  // a run steps without it
  return py::float_(static_cast<const Function*>(context)->f(contact, delta, rate, v0));
}

}  // namespace

std::shared_ptr<const OwnLaw> law_of(const py::function& f, const std::string& name,
                                     const std::string& what) {
  OwnLaw law;
  law.force = call;
  law.context = std::make_shared<Function>(f);
  law.name = visible_brief(name);
  law.digest = digest(what);
  return std::make_shared<const OwnLaw>(std::move(law));
}

}  // namespace freeplay::python
