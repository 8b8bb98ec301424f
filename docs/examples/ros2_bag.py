#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Calibrates a camera from the images of a ROS 2 bag, and writes its file for Alidade and its file for ROS.

usage: ros2_bag.py BAG TOPIC BOARD CAMERA_FILE [STEP]

BAG is a folder with metadata.yaml, TOPIC one of sensor_msgs/Image or sensor_msgs/CompressedImage. Every STEP-th image is
used (default 10). The bag is read by rosbags (pip install rosbags) or by rosbag2_py, which comes with ROS 2.
example: ros2_bag.py drive/ /camera/image_raw checkerboard:9x6:25mm camera.yaml
"""
import pathlib
import sys

import alidade
import cv2
import numpy as np

# sensor_msgs/image_encodings.hpp: type and channels of a pixel, and what OpenCV calls the step to grey or to B, G, R.
# OpenCV names a mosaic by its second row from the second column on, ROS by the top left corner.
ENCODINGS = {
    "mono8": (np.uint8, 1, None), "8UC1": (np.uint8, 1, None), "mono16": (np.uint16, 1, None), "16UC1": (np.uint16, 1, None),
    "bgr8": (np.uint8, 3, None), "8UC3": (np.uint8, 3, None), "rgb8": (np.uint8, 3, cv2.COLOR_RGB2BGR),
    "bgra8": (np.uint8, 4, cv2.COLOR_BGRA2BGR), "rgba8": (np.uint8, 4, cv2.COLOR_RGBA2BGR),
    "bgr16": (np.uint16, 3, None), "rgb16": (np.uint16, 3, cv2.COLOR_RGB2BGR),
    **{f"bayer_{ros}{bits}": (kind, 1, getattr(cv2, f"COLOR_Bayer{opencv}2BGR"))
       for ros, opencv in (("rggb", "BG"), ("bggr", "RG"), ("gbrg", "GR"), ("grbg", "GB"))
       for bits, kind in ((8, np.uint8), (16, np.uint16))},
}


def image_array(message) -> np.ndarray:
    """Returns the image of a sensor_msgs/Image or CompressedImage: (height, width) or (height, width, 3) in B, G, R.

    ValueError: an encoding that is not in ENCODINGS, or data that is too short or no image.
    """
    data = np.frombuffer(bytes(message.data), np.uint8)
    if not hasattr(message, "encoding"):
        image = cv2.imdecode(data, cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH) if len(data) else None
        if image is None:
            raise ValueError(f"compressed image '{message.format}': its {len(data)} bytes are not an image that OpenCV reads")
        return image
    if message.encoding not in ENCODINGS:
        raise ValueError(f"encoding '{message.encoding}' is not known; expected one of {', '.join(ENCODINGS)}")
    kind, channels, conversion = ENCODINGS[message.encoding]
    kind = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    row_bytes = message.width * channels * kind.itemsize
    if message.step < row_bytes or len(data) < message.step * message.height:
        raise ValueError(f"{len(data)} bytes in rows of {message.step}; expected {message.height} rows of {row_bytes} or more")
    rows = data[:message.step * message.height].reshape(message.height, message.step)[:, :row_bytes]  # without padding
    shape = (message.height, message.width) if channels == 1 else (message.height, message.width, channels)
    image = np.ascontiguousarray(rows).view(kind).reshape(shape).astype(kind.newbyteorder("="), copy=False)
    return image if conversion is None else cv2.cvtColor(image, conversion)


def messages_by_rosbags(bag: str, topic: str):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore
    with AnyReader([pathlib.Path(bag)], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        for connection, _, data in reader.messages(connections=connections) if connections else ():
            yield reader.deserialize(data, connection.msgtype)


def messages_by_rosbag2(bag: str, topic: str):
    import rosbag2_py
    from rclpy.serialization import deserialize_message
    from rosidl_runtime_py.utilities import get_message
    storage = rosbag2_py.Info().read_metadata(bag, "").storage_identifier
    reader = rosbag2_py.SequentialReader()
    reader.open(rosbag2_py.StorageOptions(uri=bag, storage_id=storage), rosbag2_py.ConverterOptions("cdr", "cdr"))
    types = {t.name: t.type for t in reader.get_all_topics_and_types()}
    while reader.has_next():
        name, data, _ = reader.read_next()
        if name == topic:
            yield deserialize_message(data, get_message(types[name]))


def reader_of_bags():
    """Returns the function that reads the messages of a bag; None if no package for it is installed."""
    for package, function in (("rosbags", messages_by_rosbags), ("rosbag2_py", messages_by_rosbag2)):
        try:
            __import__(package)
            return function
        except ImportError:
            continue
    return None


def main(arguments) -> int:
    if len(arguments) not in (4, 5):
        print(__doc__, file=sys.stderr)
        return 2
    bag, topic, board, camera_file = arguments[:4]
    step = int(arguments[4]) if len(arguments) == 5 else 10
    messages = reader_of_bags()
    if messages is None:
        print("ros2_bag.py: no package that reads ROS 2 bags is installed; expected rosbags or rosbag2_py; next: run "
              "'pip install rosbags', or source the setup file of ROS 2", file=sys.stderr)
        return 1
    images = [image_array(message) for i, message in enumerate(messages(bag, topic)) if i % step == 0]
    if not images:
        print(f"{bag}: no images of the topic {topic}; next: list its topics by 'ros2 bag info {bag}'", file=sys.stderr)
        return 1
    survey = alidade.detect(images, board)
    print(survey, *survey.reasons, sep="\n")
    result = alidade.calibrate(survey)
    print(result, *result.warnings, sep="\n")
    if not result.is_usable:
        return 3
    result.save(camera_file)
    try:
        alidade.save_camera(pathlib.Path(camera_file).with_suffix(".ros.yaml"), result.camera, "ros")
    except alidade.InputError as error:  # a lens that ROS has no model for
        print(error, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
