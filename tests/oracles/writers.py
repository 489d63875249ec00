"""Recordings as the reference libraries write them."""
import dataclasses
import pathlib
import shutil
import sqlite3
import struct

import numpy
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as McapRos2Writer
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# Small, so that even a short drive has several.
CHUNK_BYTES = 40_000


def ros1_store():
    store = get_typestore(Stores.ROS1_NOETIC)
    definition = "geometry_msgs/TransformStamped[] transforms"
    store.register(get_types_from_msg(definition, "tf2_msgs/msg/TFMessage"))
    return store


def ros2_store():
    return get_typestore(Stores.ROS2_JAZZY)


def type2(name):
    """sensor_msgs/LaserScan of ROS 1 is sensor_msgs/msg/LaserScan of ROS 2."""
    return name.replace("/", "/msg/", 1)


def built(store, name, values):
    """A message of rosbags; what is not given is zero."""
    fields = {}
    for field, (kind, detail) in store.get_msgdef(name).fields:
        value = values.get(field)
        if kind == Nodetype.NAME:
            fields[field] = built(store, detail, value or {})
        elif kind == Nodetype.BASE:
            default = "" if detail[0] == "string" else 0
            fields[field] = default if value is None else value
        else:
            fields[field] = built_array(store, kind, detail, value)
    return store.types[name](**fields)


def plain(value):
    """The same as dictionaries and lists."""
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [plain(one) for one in value]
    if hasattr(value, "__msgtype__"):
        fields = {field.name for field in dataclasses.fields(value)} - {"__msgtype__"}
        return {name: plain(getattr(value, name)) for name in fields}
    return value


def built_array(store, kind, detail, values):
    (inner_kind, inner), length = detail
    if inner_kind == Nodetype.NAME:
        return [built(store, inner, value) for value in values or []]
    if values is None:
        return numpy.zeros(length if kind == Nodetype.ARRAY else 0, dtype=inner[0])
    return numpy.asarray(values, dtype=inner[0])


class Encoder:
    """The bytes of messages, and what describes them."""

    def __init__(self, encoding):
        self.is_ros1 = encoding == "ros1"
        self.is_little = encoding != "cdr_big"
        self.store = ros1_store() if self.is_ros1 else ros2_store()
        self.channel_encoding = "ros1" if self.is_ros1 else "cdr"
        self.schema_encoding = "ros1msg" if self.is_ros1 else "ros2msg"

    def bytes_of(self, message):
        name = type2(message.type)
        value = built(self.store, name, message.values)
        if self.is_ros1:
            return bytes(self.store.serialize_ros1(value, name))
        return bytes(self.store.serialize_cdr(value, name, little_endian=self.is_little))

    def definition(self, name):
        version = 1 if self.is_ros1 else 2
        return self.store.generate_msgdef(type2(name), ros_version=version)[0]

    def schema_name(self, name):
        return name if self.is_ros1 else type2(name)


# rosbags.


def write_bag(path, messages, packing=None):
    encoder = Encoder("ros1")
    writer = Writer1(path)
    writer.chunk_threshold = CHUNK_BYTES
    if packing:
        writer.set_compression(Writer1.CompressionFormat[packing.upper()])
    with writer:
        connections = {}
        for message in messages:
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic,
                    type2(message.type),
                    typestore=encoder.store,
                    latching=1 if message.topic == "/tf_static" else None,
                )
            writer.write(connections[message.topic], message.recorded_ns, encoder.bytes_of(message))


def write_rosbag2(path, messages, storage="sqlite3", packing="none", version=9, encoding="cdr"):
    encoder = Encoder(encoding)
    writer = Writer2(path, version=version, storage_plugin=StoragePlugin[storage.upper()])
    writer.set_compression(CompressionMode[packing.upper()], CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for message in messages:
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic, type2(message.type), typestore=encoder.store
                )
            writer.write(connections[message.topic], message.recorded_ns, encoder.bytes_of(message))


def database_of(folder):
    (database,) = pathlib.Path(folder).glob("*.db3")
    return database


def write_old_rosbag2(path, messages):
    """As before ROS 2 Iron: no definitions, no hashes, no metadata.yaml."""
    write_rosbag2(path, messages)
    (pathlib.Path(path) / "metadata.yaml").unlink()
    with sqlite3.connect(database_of(path)) as database:
        database.executescript(
            "DROP TABLE message_definitions; DROP TABLE schema; DROP TABLE metadata;"
            " ALTER TABLE topics DROP COLUMN type_description_hash;"
        )
    database.close()


def write_open_rosbag2(path, messages):
    """As a recorder leaves it that was killed: half of it in the log of writes."""
    write_rosbag2(path.with_suffix(".whole"), messages)
    source = database_of(path.with_suffix(".whole"))
    path.mkdir()
    database = sqlite3.connect(path / "open_0.db3", isolation_level=None)
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA wal_autocheckpoint=0")
    database.execute("ATTACH ? AS whole", (str(source),))
    tables = ("schema", "metadata", "topics", "message_definitions")
    for table in tables:
        database.execute(f"CREATE TABLE {table} AS SELECT * FROM whole.{table}")
    database.execute(
        "CREATE TABLE messages"
        "(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"
    )
    half = len(messages) // 2
    copy = "INSERT INTO messages SELECT id, topic_id, timestamp, data FROM whole.messages WHERE id"
    database.execute(f"{copy} <= {half}")
    database.execute("PRAGMA wal_checkpoint(FULL)")
    database.execute(f"{copy} > {half}")
    left = path.with_suffix(".left")
    shutil.copytree(path, left)
    database.close()
    shutil.rmtree(path)
    left.rename(path)


# mcap.


def write_mcap(path, messages, encoding="cdr", publishers=1, **options):
    """`options` are those of mcap.writer.Writer. Of several publishers each topic has a channel."""
    encoder = Encoder(encoding)
    writer = McapWriter(str(path), chunk_size=CHUNK_BYTES, **options)
    writer.start(profile="ros1" if encoder.is_ros1 else "ros2", library="oracles")
    schemas = {}
    channels = {}
    for number, message in enumerate(messages):
        publisher = number % publishers
        if message.type not in schemas:
            schemas[message.type] = writer.register_schema(
                encoder.schema_name(message.type),
                encoder.schema_encoding,
                encoder.definition(message.type).encode(),
            )
        if (message.topic, publisher) not in channels:
            channels[message.topic, publisher] = writer.register_channel(
                message.topic, encoder.channel_encoding, schemas[message.type]
            )
        writer.add_message(
            channels[message.topic, publisher],
            log_time=message.recorded_ns,
            publish_time=message.recorded_ns - 5,
            data=encoder.bytes_of(message),
        )
    writer.add_metadata("who", {"wrote": "this"})
    writer.add_attachment(messages[0].recorded_ns, 0, "note.txt", "text/plain", b"not a message")
    writer.finish()


def write_mcap_ros2(path, messages, **options):
    """By mcap_ros2, which serialises by itself."""
    encoder = Encoder("cdr")
    with McapRos2Writer(str(path), chunk_size=CHUNK_BYTES, **options) as writer:
        schemas = {}
        for message in messages:
            if message.type not in schemas:
                schemas[message.type] = writer.register_msgdef(
                    type2(message.type), encoder.definition(message.type)
                )
            values = plain(built(encoder.store, type2(message.type), message.values))
            writer.write_message(message.topic, schemas[message.type], values, message.recorded_ns)


def pad_records(path, padded):
    """Bytes behind the fields of records, which readers pass: later versions may have more fields.
    The file must be without chunks and summary, whose offsets would be wrong."""
    magic = 8
    message = 5
    source = pathlib.Path(path).read_bytes()
    result = bytearray(source[:magic])
    at = magic
    while at < len(source) - magic:
        op, length = struct.unpack_from("<BQ", source, at)
        content = source[at + 9 : at + 9 + length]
        is_footer = op == 2
        if op != message and not is_footer:
            content += b"more"
        result += struct.pack("<BQ", op, len(content)) + content
        if op == 4:  # a kind of record that there is not
            result += struct.pack("<BQ", 0x90, 5) + b"other"
        at += 9 + length
    pathlib.Path(padded).write_bytes(bytes(result) + source[-magic:])


NO_SUMMARY = {
    "index_types": IndexType.NONE,
    "repeat_channels": False,
    "repeat_schemas": False,
    "use_statistics": False,
    "use_summary_offsets": False,
}
MCAP_OPTIONS = {
    "all": {},
    "without statistics": {"use_statistics": False},
    "without offsets": {"use_summary_offsets": False},
    "without repeated schemas": {"repeat_schemas": False},
    "without repeated channels": {"repeat_channels": False},
    "without repeated schemas and channels": {"repeat_schemas": False, "repeat_channels": False},
    "index of chunks alone": {"index_types": IndexType.CHUNK},
    "index of messages alone": {"index_types": IndexType.MESSAGE},
    "without index": {"index_types": IndexType.NONE},
    "without summary": NO_SUMMARY,
    "without checksums": {"enable_crcs": False},
    "with all checksums": {"enable_data_crcs": True},
}
MCAP_PACKINGS = {
    "plain chunks": {"compression": CompressionType.NONE},
    "lz4": {"compression": CompressionType.LZ4},
    "zstd": {"compression": CompressionType.ZSTD},
    "no chunks": {"use_chunking": False},
}
