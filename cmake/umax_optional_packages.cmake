# What the build can do without, each found once.
# who only wants the program needs no Python. It is the system's, which has numpy as tools/packages.python lists it, whatever
# stands before it in PATH; -DPython_EXECUTABLE=PATH chooses another
if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
if(Python_FOUND)
  find_package(pybind11 2.10 QUIET CONFIG)
endif()

# who only wants the program needs no test framework
find_package(Catch2 QUIET)
