# scikit-build of Debian 12 is told by setup.py what pyproject.toml cannot say yet.
import re
from pathlib import Path

from skbuild import setup

version = re.search(r"project\(freeplay VERSION ([\d.]+)", Path("CMakeLists.txt").read_text())[1]

setup(
    name="freeplay",
    version=version,
    description="Dynamics of planar mechanisms whose joints have clearance, in two formulations",
    author="the Freeplay authors",
    license="BSD-3-Clause",
    python_requires=">=3.11",
    install_requires=["numpy", "pandas", "tomli_w"],
    packages=["freeplay"],
    package_dir={"freeplay": "python/freeplay"},
    package_data={"freeplay": ["py.typed", "*.pyi"]},
    cmake_args=["-DFREEPLAY_PYTHON=ON", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG"],
)
