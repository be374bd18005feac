"""FMUs in a process of their own, which they may end without harm.

    simulation  the face of `cosim.Simulation`, on the side of the caller
    process     the child as its parent sees it: started, asked, watched, ended
    shared      memory that both see: results, and which call an FMU is in
    parcel      a specification on its way to the child
    verdict     the error when the child died
    start       the child's first lines; imports `child` and nothing else
    child       prepares a simulation and runs it as it is told

Requests go down as pickles. Answers come back as JSON, so that nothing the child says is executed.
"""
