"""FMUs in a child process, whose crash does not end the caller.

    simulation  `cosim.Simulation` in the parent process
    process     the child in the parent: started, asked, watched, ended
    messages    what passes between both, and the error when the child died
    start       the child's first lines; imports `child` and nothing else
    child       prepares a simulation and runs it on request

Requests are pickles. Answers are JSON, so that nothing from the child is executed.
"""
