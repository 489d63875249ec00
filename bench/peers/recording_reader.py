"""Reads a recording with a library that comes as a Python wheel, for bench/recordings.py.

  recording_reader.py rosbags|mcap scans|raw|all FILE
  recording_reader.py --versions

scans: laser scans alone, decoded; raw: the same, not decoded; all: every message, not decoded.
Prints one JSON object: CPU and wall time after the imports, messages and beams.
"""
import importlib.metadata
import json
import pathlib
import sys
import time

SCAN_TYPE = "sensor_msgs/msg/LaserScan"


def by_rosbags(path, mode):
    from rosbags.highlevel import AnyReader

    def read():
        messages = beams = 0
        with AnyReader([pathlib.Path(path)]) as reader:
            wanted = [c for c in reader.connections if mode == "all" or c.msgtype == SCAN_TYPE]
            for connection, _, data in reader.messages(connections=wanted):
                messages += 1
                if mode == "scans":
                    beams += reader.deserialize(data, connection.msgtype).ranges.size
        return messages, beams

    return read


def by_mcap(path, mode):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    def read():
        messages = beams = 0
        with open(path, "rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            summary = reader.get_summary()
            wanted = [
                channel.topic
                for channel in summary.channels.values()
                if mode == "all" or summary.schemas[channel.schema_id].name == SCAN_TYPE
            ]
            if mode == "scans":
                for decoded in reader.iter_decoded_messages(topics=wanted):
                    messages += 1
                    beams += len(decoded.decoded_message.ranges)
            else:
                for _ in reader.iter_messages(topics=wanted):
                    messages += 1
        return messages, beams

    return read


def main():
    if sys.argv[1:] == ["--versions"]:
        packages = ["rosbags", "mcap"]
        print(json.dumps([f"{name} {importlib.metadata.version(name)}" for name in packages]))
        return
    if len(sys.argv) != 4 or sys.argv[2] not in ("scans", "raw", "all"):
        sys.exit(__doc__)
    library, mode, path = sys.argv[1:]
    read = {"rosbags": by_rosbags, "mcap": by_mcap}[library](path, mode)
    wall, cpu = time.perf_counter(), time.process_time()
    messages, beams = read()
    cost = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall}
    print(json.dumps({**cost, "messages": messages, "beams": beams}))


if __name__ == "__main__":
    main()
