// The compiled module of the Python package freeplay, which python/freeplay/*.py uses.
#include "errors.hpp"
#include "record.hpp"
#include "version.hpp"

PYBIND11_MODULE(_freeplay, m) {
  m.doc() = "Compiled part of the package freeplay. Programs import freeplay.";
  freeplay::python::register_errors();
  freeplay::python::bind_runs(m);
  freeplay::python::bind_studies(m);
  freeplay::python::bind_motions(m);
  m.def("version", [] { return std::string(freeplay::version); });
  m.def("commit", [] { return std::string(freeplay::commit); });
  m.def("refuse_forked", &freeplay::python::refuse_forked);
}
