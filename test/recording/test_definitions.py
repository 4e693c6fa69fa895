"""A recording carries the full definition of its messages."""

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.bags.definitions import message_definition

LINE = "=" * 80


def write(folder, name, text):
    package, short = name.split("/")
    (folder / package / "msg").mkdir(parents=True, exist_ok=True)
    (folder / package / "msg" / f"{short}.msg").write_text(text)


def test_a_definition_is_followed_by_each_type_it_uses_once_in_the_order_of_ros2_bag(tmp_path):
    root = (
        "# z_msgs/NotUsed is only in a comment\n"
        "uint8 CONSTANT=1  # not_used\n"
        "Own[<=3] own      # of the same package\n"
        "a_msgs/Other[] others\n"
        "string<=5 name\n"
        "float64[3] vector\n"
    )
    write(tmp_path, "m_msgs/Root", root)
    write(tmp_path, "m_msgs/Own", "a_msgs/Other other\n")
    write(tmp_path, "a_msgs/Other", "Inner inner\n")
    write(tmp_path, "a_msgs/Inner", "int32 value\n")

    assert message_definition("m_msgs/msg/Root", [tmp_path]) == (
        f"{root}"
        f"\n{LINE}\nMSG: a_msgs/Other\nInner inner\n"
        f"\n{LINE}\nMSG: a_msgs/Inner\nint32 value\n"
        f"\n{LINE}\nMSG: m_msgs/Own\na_msgs/Other other\n"
    )


def test_rosbags_understands_the_definition_of_every_message_of_the_suite(share):
    for file in (share / "tissue_probe_msgs" / "msg").glob("*.msg"):
        typename = f"tissue_probe_msgs/msg/{file.stem}"
        definition = message_definition(typename, [share])
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(definition, typename))
        assert store.get_msgdef(typename)
        assert definition.startswith(file.read_text())


def test_a_folder_named_first_is_searched_first(tmp_path):
    write(tmp_path / "first", "m_msgs/Root", "int8 first\n")
    write(tmp_path / "second", "m_msgs/Root", "int8 second\n")
    folders = [tmp_path / "none", tmp_path / "first", tmp_path / "second"]
    assert message_definition("m_msgs/msg/Root", folders) == "int8 first\n"


def test_a_type_that_is_not_found_is_named_with_the_folders_searched(tmp_path):
    write(tmp_path, "m_msgs/Root", "missing_msgs/Gone gone\n")
    with pytest.raises(FileNotFoundError, match="missing_msgs/Gone") as raised:
        message_definition("m_msgs/msg/Root", [tmp_path])
    assert str(tmp_path) in str(raised.value)
