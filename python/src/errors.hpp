// Errors of the library as exceptions of Python.
#pragma once

namespace freeplay::python {

/// Once, when the module is made. The classes stand in freeplay/errors.py.
void register_errors();

}  // namespace freeplay::python
