from stickslip.cosim import (
    Adaptive as Adaptive,
)
from stickslip.cosim import (
    Coupling as Coupling,
)
from stickslip.cosim import (
    Fmu as Fmu,
)
from stickslip.cosim import (
    Function as Function,
)
from stickslip.cosim import (
    Record as Record,
)
from stickslip.cosim import (
    Result as Result,
)
from stickslip.cosim import (
    Scenario as Scenario,
)
from stickslip.cosim import (
    Simulation as Simulation,
)
from stickslip.cosim import (
    SineSweep as SineSweep,
)
from stickslip.cosim import (
    Specification as Specification,
)
from stickslip.cosim import (
    System as System,
)
from stickslip.cosim import (
    Table as Table,
)
from stickslip.cosim import (
    Trapezoid as Trapezoid,
)
from stickslip.cosim import (
    read_ssp as read_ssp,
)
from stickslip.cosim import (
    read_tables as read_tables,
)
from stickslip.cosim import (
    write_fmu as write_fmu,
)
from stickslip.cosim import (
    write_ssp as write_ssp,
)
from stickslip.cosim.control import (
    linearise as linearise,
)
from stickslip.cosim.control import (
    measure_response as measure_response,
)
from stickslip.fmucheck import (
    check as check,
)
from stickslip.models import (
    build_fmu as build_fmu,
)
from stickslip.models import (
    export_lti as export_lti,
)
from stickslip.pipeline.log_learning import (
    learn as learn,
)
from stickslip.pipeline.log_learning import (
    write_learned as write_learned,
)
from stickslip.planning import (
    plan as plan,
)
from stickslip.servo import (
    Axis as Axis,
)
from stickslip.servo import (
    LoopSpecification as LoopSpecification,
)
from stickslip.servo import (
    VelocityLoop as VelocityLoop,
)
from stickslip.servo import (
    design_velocity_filter as design_velocity_filter,
)
from stickslip.servo import (
    design_velocity_loop as design_velocity_loop,
)
from stickslip.simulation import (
    simulate as simulate,
)

__version__: str
