"""`ros2 param`, as its own calls go: list, describe, get, set, and files."""

from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, GetParameterTypes, ListParameters, SetParameters, SetParametersAtomically

NAMES = {
    "command.after", "command.decay", "command.timeout", "frame_id", "lock_step", "particles.fields", "particles.max_bytes", "particles.mode",
    "particles.rate", "particles.reliability", "particles.stride", "paused", "real_time_factor", "record", "record.cells", "record.every", "record.force",
    "record.precision", "record.snapshots", "record.variables", "record.when_full", "state.rate", "state.reliability", "step", "use_sim_time",
}


def double(name, value):
    return Parameter(name=name, value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value))


def test_parameters_are_declared_with_descriptions_and_ranges(start, peer):
    start()
    listed = peer.call(ListParameters, "/matpoint/list_parameters").result
    assert set(listed.names) == NAMES
    descriptors = peer.call(DescribeParameters, "/matpoint/describe_parameters", names=sorted(NAMES)).descriptors
    types = peer.call(GetParameterTypes, "/matpoint/get_parameter_types", names=sorted(NAMES)).types
    values = peer.call(GetParameters, "/matpoint/get_parameters", names=sorted(NAMES)).values
    assert [d.type for d in descriptors] == list(types) == [v.type for v in values]
    for d in descriptors:
        assert len(d.description) > 10, d.name
        assert len(d.floating_point_range) == (d.type == ParameterType.PARAMETER_DOUBLE), d.name
        assert len(d.integer_range) == (d.type == ParameterType.PARAMETER_INTEGER), d.name
    by_name = {d.name: d for d in descriptors}
    assert by_name["real_time_factor"].floating_point_range[0].from_value == 0.0
    assert by_name["paused"].read_only and not by_name["step"].read_only
    assert "strided, whole, tiles" in by_name["particles.mode"].additional_constraints


def test_parameters_are_set_or_refused_with_the_reason(start, peer):
    start()
    events = peer.listen(ParameterEvent, "/parameter_events")
    peer.spin(1.0)
    set_one = peer.client(SetParameters, "/matpoint/set_parameters")
    [good, wrong] = peer.call(SetParameters, set_one, parameters=[double("real_time_factor", 2.5), double("step", -1.0)]).results
    assert good.successful
    assert not wrong.successful and wrong.reason == "parameter `step` is -1; allowed is a number from 0.000000001 to 1000"
    peer.until(lambda: events, what="event")
    assert [p.name for p in events[0].changed_parameters] == ["real_time_factor"] and events[0].node == "/matpoint"
    assert peer.call(GetParameters, "/matpoint/get_parameters", names=["real_time_factor"]).values[0].double_value == 2.5
    # All or none.
    both = [double("real_time_factor", 3.0), double("nothing", 1.0)]
    result = peer.call(SetParametersAtomically, "/matpoint/set_parameters_atomically", parameters=both).result
    assert not result.successful and "no parameter `nothing`" in result.reason
    assert peer.call(GetParameters, "/matpoint/get_parameters", names=["real_time_factor"]).values[0].double_value == 2.5
    [fixed] = peer.call(SetParameters, set_one, parameters=[Parameter(name="paused", value=ParameterValue(type=1, bool_value=True))]).results
    assert not fixed.successful and "only be set when the node starts" in fixed.reason


def test_parameter_files_of_launch_files(start, peer, tmp_path):
    file = tmp_path / "params.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {step: 0.5, unknown_here: 1}\n"
        "matpoint:\n  ros__parameters: {step: 0.02, particles: {fields: [velocity, id], stride: 3}}\n"
    )
    start(ros_args=["--params-file", str(file)], parameters={"particles.stride": 4})
    names = ["step", "particles.stride", "particles.fields"]
    step, stride, fields = peer.call(GetParameters, "/matpoint/get_parameters", names=names).values
    assert (step.double_value, stride.integer_value, fields.string_array_value) == (0.02, 4, ["velocity", "id"])
