"""The framed serial link between a gripper microcontroller and its host.

:class:`GripLink` is a gripper at a port, :class:`Daemon` a gripd at a socket, :class:`VirtualMcu` a gripper without hardware. The cores without IO are
:class:`grip_link.device.DeviceLink` and :class:`grip_link.decoder.Decoder`.
"""

from __future__ import annotations

from .client import GripLink, LinkClosed, Sample
from .daemon import Daemon, DaemonError
from .decoder import Counters, Decoder, Role, Verdict
from .device import DeviceLink, Drive, DriveKind
from .mcu import Pty, VirtualMcu, default_ident
from .messages import ChannelKind, Config, DeviceState, FaultCode, Ident, LossAction, SampleFormat, Status
from .stream import StreamClosed

__all__ = [
    "ChannelKind", "Config", "Counters", "Daemon", "DaemonError", "Decoder", "DeviceLink", "DeviceState", "Drive", "DriveKind", "FaultCode",
    "GripLink", "Ident", "LinkClosed", "LossAction", "Pty", "Role",
    "Sample", "SampleFormat", "Status", "StreamClosed", "Verdict", "VirtualMcu", "default_ident",
]  # fmt: skip
