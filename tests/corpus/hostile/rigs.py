"""Drives behind sockets that answer what they should not, rigs that return no logs, kept logs."""

from functools import partial
from pathlib import Path

from tests.corpus.hostile.case import Case, Content, python

_ANSWERS = """
import contextlib, json, socket, threading
listener = socket.create_server(("127.0.0.1", 0))
def answer(seq):
    sound = dict(
        seq=seq, protocol=1, T_s=5e-4, heartbeat=0.5, last=0, clock=1.0, position=0.0, loaded=0
    )
    return ANSWER
def serve():
    with contextlib.suppress(OSError):
        while True:
            connection, _ = listener.accept()
            with connection, contextlib.suppress(OSError):
                while received := connection.recv(1 << 16):
                    said = answer(json.loads(received.splitlines()[0])["seq"])
                    line = said if isinstance(said, bytes) else json.dumps(said).encode()
                    connection.sendall(line + b"\\n")
server = threading.Thread(target=serve)
server.start()
address = "127.0.0.1:%d" % listener.getsockname()[1]
limits = ss.RigLimits((-1.0, 1.0), 1.0, 100.0, 1.0)
try:
    with ss.SocketRig(address, ss.Datasheet(), limits, patience=0.2, retry=0.05) as rig:
        rig.push(np.zeros(3))
finally:
    listener.shutdown(socket.SHUT_RDWR)
    listener.close()
    server.join()
"""
_LIMITS = "limits = ss.RigLimits((-1.0, 1.0), 1.0, 100.0, 1.0)\n"
_LOOP = (
    "loop = ss.design_velocity_loop(ss.Axis(5.0, 20.0, 1e-4), ss.LoopSpecification(50.0, 60.0))\n"
)
_RIG = (
    _LIMITS
    + """
class Bench(ss.Rig):
    def move(self, command):
        return {}
with {} as rig:
    rig.push(np.zeros(3))
"""
)
_python = partial(python, 24)
_BENCH = "Bench(ss.Datasheet(), 5e-4, limits)"


def _answers(name: str, about: str, says: str, answer: str) -> Case:
    """Return a case of a server that gives an answer, as an expression in ``seq`` and ``sound``."""
    code = _ANSWERS.replace("ANSWER", answer)
    return Case(24, f"answer-{name}", f"a drive that answers {about}", says, "", code=code)


def _returns(name: str, about: str, says: str, log: str) -> Case:
    return _python(f"log-{name}", f"a rig that returns {about}", says, _RIG.format(log, _BENCH))


def _kept(name: str, about: str, says: str, file: str, content: Content) -> Case:
    """Return a case of a folder of kept logs with a file that is damaged."""
    log = "ss.Log(np.zeros(3), np.zeros(3), np.zeros(3))"
    code = _RIG.format(log, f'ss.KeptRig({_BENCH}, "kept")')
    about = f"kept logs, of which the first is {about}"
    files = {f"kept/motion-0001.{file}": content}
    return Case(24, f"kept-{name}", about, says, "", files, code)


def _command(name: str, about: str, says: str, arguments: str) -> Case:
    return _python(f"command-{name}", f"a command {about}", says, f"{_LOOP}ss.Command({arguments})")


_PROTOCOL = "its answer to 'hello' is not of protocol 1"
CASES = [
    _answers("http", "as a web server does", "connection lost .*Expecting value", 'b"HTTP/1.1 400 Bad Request"'),
    _answers("deep", "with lists a hundred thousand deep", "nested too deeply", 'b"[" * 100_000'),
    _answers("long", "with a line of 2 MB", "a line is longer than 1048576 bytes", 'b"x" * (1 << 21)'),
    _answers("text", "with a sample period that is text", f"{_PROTOCOL}: ValueError", "sound | dict(T_s='fast')"),
    _answers("other-protocol", "in another protocol", f"{_PROTOCOL}: ValueError protocol 2", "sound | dict(protocol=2)"),
    _answers("lines", "with an error of two lines", "refuses to hello: no stickslip: all is well$", r"sound | dict(error='no\nstickslip: all is well')"),
    _answers("never-loads", "that it has loaded nothing, for ever", "its answer to 'load' is not of protocol 1: ValueError loaded 0, after 0", "sound"),
    _python("port-beyond", "a port that is none, which would be taken modulo 65536", "expected HOST:PORT, a port from 1 to 65535", f'{_LIMITS}ss.SocketRig("127.0.0.1:99999", ss.Datasheet(), limits)'),
    _python("limits-travel", "a travel of three positions", "expected numbers, and two of them as travel", "ss.RigLimits((-1.0, 0.0, 1.0), 1.0, 1.0, 1.0)"),
    _command("period", "with a sample period of NaN", "T_s = nan s; expected more than 0", "np.nan, loop, force=[0.0]"),
    _command("matrix", "that is a matrix", r"force: expected numbers \(n,\)", "5e-4, loop, force=np.zeros((3, 2))"),
    _returns("unequal", "signals of two lengths", "t, x_enc and F_m have 3, 2 and 3 values", "ss.Log(np.zeros(3), np.zeros(2), np.zeros(3))"),
    _returns("short", "fewer samples than the command has", "a log of 2 samples; expected 3", "ss.Log(np.zeros(2), np.zeros(2), np.zeros(2))"),
    _returns("nan", "a position of NaN", "x_enc of the log is nan in sample 0", "ss.Log(np.zeros(3), np.full(3, np.nan), np.zeros(3))"),
    _kept("text", "text", r"motion-0001.npz: is damaged .*delete this file to run the motion again", "npz", "hello"),
    _kept("folder", "a folder, into which no log could be written after the motion", "motion-0001.npz: is damaged", "npz", Path.mkdir),
    _kept("begun-list", "begun, as a list", "motion-0001.json: is damaged", "json", "[]"),
]  # fmt: skip
