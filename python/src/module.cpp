// The compiled module of the Python package freeplay, which python/freeplay/*.py uses.

#include <pybind11/pybind11.h>

#include "io/files/build_identity.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "record.hpp"
#include "values/snapshot.hpp"
#include "values/stop.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// Raises the exception that errors.py makes of the message.
template <class... Given>
void raise(const char* maker, const Given&... given) {
  const py::object error = py::module_::import("freeplay.errors").attr(maker)(given...);
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
}

/// Maps errors of the library to the exceptions of freeplay/errors.py.
void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const ModelError& e) {
    raise("scene_error", std::string(e.what()), e.key, e.message);
  } catch (const SnapshotError& e) {
    raise("SnapshotError", std::string(e.what()));
  } catch (const OutputError& e) {
    raise("OutputError", std::string(e.what()));
  } catch (const Interrupted& e) {
    raise("Interrupted", std::string(e.what()));
  }
}

}  // namespace
}  // namespace freeplay::python

PYBIND11_MODULE(_freeplay, m) {
  m.doc() = "Compiled part of the package freeplay. Programs import freeplay.";
  py::register_local_exception_translator(freeplay::python::translate);
  freeplay::python::bind_runs(m);
  freeplay::python::bind_studies(m);
  freeplay::python::bind_motions(m);
  m.def("version", [] { return std::string(freeplay::build_identity().version); });
  m.def("commit", [] { return std::string(freeplay::build_identity().commit); });
  m.def("refuse_forked", &freeplay::python::refuse_forked);
}
