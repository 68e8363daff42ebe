"""Long robustness checks of the program and the Python module; `scripts/soak` runs them.

__main__.py    arguments, order of the checks, table
context.py     what all checks share: settings, folders of the cases, faults, figures of the table
process.py     one run of a program, with its time, its memory and its exit code
frames.py      reads frames and statistics, and compares folders of them
meshes.py      generated surfaces, and OBJ files of them
scenes.py      shipped and generated scenes
kills.py       runs that are killed and resumed
damage.py      runs that are resumed from damaged files
outcome.py     a run of a file that may be invalid
mutants.py     changed bytes and words of shipped files
geometry.py    degenerate and extreme surfaces
bounds.py      large inputs
calls.py       random calls of the Python module, in child processes
caller.py      the child process of calls.py
operations.py  the calls of simulations and scenes, and the table of all calls
objects.py     the objects that are kept, and the calls of meshes, lattices, bodies and colliders
arguments.py   random arguments of these calls
"""
