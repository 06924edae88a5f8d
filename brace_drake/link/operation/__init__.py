"""What a host does with a device: record, deploy, run the twin beside it.

`station` takes a device into use, `control` is the scenario's controller with
the device in the plant's place, `session` follows a reference under the safety
supervisor. `recorder` and `campaign` write what happened into a `journal`,
`deploy` tries a controller dry before it arms, `beside` compares with the twin.
"""

from brace_drake.link.operation.campaign import LoadPlan, RecordRuns
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.deploy import RunController
from brace_drake.link.operation.recorder import Recorder
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.station import MakeControl, OpenDevice

__all__ = [
    "HostControl",
    "LoadPlan",
    "MakeControl",
    "OpenDevice",
    "RecordRuns",
    "Recorder",
    "RunController",
    "Session",
]
