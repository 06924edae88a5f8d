"""A serial port is opened, with one line for each way in which it fails."""

from __future__ import annotations

import errno

import serial
from serial.tools import list_ports

from brace_drake.core.errors import LinkError
from brace_drake.link.protocol.codec import Decoder
from brace_drake.link.protocol.messages import BAUD, VERSION

_IN_USE = (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK)


def OpenPort(path: str, baud: int = BAUD) -> serial.SerialBase:
    """Opens a port for ourselves alone.

    Args:
        path: Such as /dev/ttyACM0 or COM3; `socket://host:port` as well.
        baud: Bits a second; of no meaning on USB and pseudo-terminals.

    Raises:
        LinkError: One line: the port, and what is wrong with it.
    """
    try:
        options = {"baudrate": baud, "timeout": 0.02, "write_timeout": 1.0}
        if "://" not in path:
            options["exclusive"] = True
        port = serial.serial_for_url(path, **options)
        port.reset_input_buffer()
    except (OSError, ValueError) as error:
        raise LinkError(_describe(path, error)) from error
    return port


def _describe(path: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    text = str(error).lower()
    if number == errno.ENOENT or "filenotfound" in text:
        return f"{path}: no such port; {_others()}"
    if number in (errno.EACCES, errno.EPERM) and "lock" not in text:
        return (
            f"{path}: no permission; on Linux the port's group, often dialout,"
            " must be one of yours"
        )
    if number in _IN_USE or "exclusively lock" in text or "denied" in text:
        return f"{path}: in use by another program"
    if number == errno.ENOTTY or "inappropriate ioctl" in text:
        return f"{path}: not a serial port"
    return f"{path}: cannot be opened: {' '.join(str(error).split())}"


def _others() -> str:
    ports = sorted(port.device for port in list_ports.comports())
    return "there are " + ", ".join(ports) if ports else "there is none"


def write_frame(port: serial.SerialBase, path: str, frame: bytes) -> None:
    """Writes a frame; one that is not taken for a second is lost.

    pyserial tells so too where all was taken, by a process that then waited a
    second for its turn.

    Raises:
        LinkError: The port is gone.
    """
    try:
        port.write(frame)
    except serial.SerialTimeoutException:
        return
    except (OSError, TypeError) as error:
        raise gone(path, error) from error


def gone(path: str, error: Exception) -> LinkError:
    """An error of a port that was open, as one of the link."""
    if isinstance(error, LinkError):
        return error
    return LinkError(f"{path}: the device is gone (unplugged, or switched off)")


def describe_stranger(decoder: Decoder) -> str:
    """Why a hello was not answered, by what came instead."""
    if decoder.bytes_read == 0:
        return "no answer to hello; is the device switched on?"
    if decoder.bad["version"]:
        return f"a device of another protocol version; ours is {VERSION}"
    if decoder.good == 0:
        return (
            f"{decoder.bytes_read} bytes and no message among them: not a"
            " brace, or another baud rate"
        )
    return "messages, but no answer to hello"
