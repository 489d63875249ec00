"""A client of the live view, of sockets alone: subscribes to topics and hands out messages."""
import base64
import json
import os
import select
import socket
import struct


class ViewClient:
    """Foxglove's protocol, as far as a listener needs it."""

    def __init__(self, port, topics=None):
        """topics: names, or None for all that there are."""
        self.topics, self.names, self.buffer = topics, {}, b""
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            (
                f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                "Sec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"
            ).encode()
        )
        while b"\r\n\r\n" not in self.buffer:
            self._read()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n", 1)[0]:
            raise RuntimeError(head.decode(errors="replace"))

    def close(self):
        self.socket.close()

    def messages(self, seconds):
        """(topic, stamp in ns, bytes) of what comes within so many seconds of silence, or until the
        server closes."""
        while True:
            frame = self._frame(seconds)
            if frame is None:
                return
            opcode, payload = frame
            if opcode == 8:
                return
            if opcode == 9:
                self._send(10, payload)
            elif opcode == 1:
                self._take_text(json.loads(payload))
            elif opcode == 2 and payload[0] == 1:
                number, stamp = struct.unpack_from("<IQ", payload, 1)
                yield self.names.get(number, ""), stamp, payload[13:]

    def _take_text(self, text):
        if text.get("op") != "advertise":
            return
        wanted = []
        for channel in text["channels"]:
            if self.topics is None or channel["topic"] in self.topics:
                self.names[channel["id"]] = channel["topic"]
                wanted.append({"id": channel["id"], "channelId": channel["id"]})
        if wanted:
            self._send(1, json.dumps({"op": "subscribe", "subscriptions": wanted}).encode())

    def _read(self, seconds=None):
        """False when nothing came, or nothing will."""
        if seconds is not None and not select.select([self.socket], [], [], seconds)[0]:
            return False
        try:
            came = self.socket.recv(1 << 18)
        except ConnectionError:
            return False
        self.buffer += came
        return bool(came)

    def _frame(self, seconds):
        while True:
            frame = self._whole_frame()
            if frame is not None or not self._read(seconds):
                return frame

    def _whole_frame(self):
        data = self.buffer
        if len(data) < 2:
            return None
        length, begin = data[1] & 127, 2
        if length == 126:
            if len(data) < 4:
                return None
            length, begin = struct.unpack_from(">H", data, 2)[0], 4
        elif length == 127:
            if len(data) < 10:
                return None
            length, begin = struct.unpack_from(">Q", data, 2)[0], 10
        if len(data) < begin + length:
            return None
        self.buffer = data[begin + length :]
        return data[0] & 15, data[begin : begin + length]

    def _send(self, opcode, payload):
        mask = os.urandom(4)
        head = bytes([128 | opcode])
        if len(payload) < 126:
            head += bytes([128 | len(payload)])
        else:
            head += bytes([128 | 126]) + struct.pack(">H", len(payload))
        self.socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))
