# SPDX-License-Identifier: GPL-3.0-or-later
"""A bind in its three parts, the long one in a thread."""

import threading

import bpy
import numpy as np
import pytest
from support import (
    add_rig,
    add_tube,
    assert_close,
    bound_rig,
    evaluated,
    expected,
    key,
    pull_to,
    state,
)

from addon.rigging import rig, shape_keys, vertex_groups
from addon.rigging.inputs import RigError


class InThread(threading.Thread):
    """Builds a job, and keeps what went wrong."""

    def __init__(self, job, progress=None):
        super().__init__()
        self.job, self.progress, self.problem = job, progress, None
        self.start()

    def run(self):
        try:
            self.job.build(self.progress)
        except BaseException as error:
            self.problem = error


def built_in_thread(job):
    thread = InThread(job)
    thread.join()
    assert thread.problem is None
    return job


def test_a_job_built_in_a_thread_is_what_a_bind_gives():
    first, second = (
        add_rig("First", "first ", dictionary="HANDLES"),
        add_rig("Second", "second ", dictionary="HANDLES"),
    )
    before = state(first)
    job = built_in_thread(rig.plan_bind(first))
    assert state(first) == before
    summary = rig.finish_bind(first, job)
    wanted = rig.bind(second)
    assert (summary.weights_computed, summary.groups) == (True, wanted.groups)
    for obj in (first, second):
        pull_to(obj, "Bend")
    np.testing.assert_array_equal(expected(first), expected(second))
    first_weights, second_weights = (
        vertex_groups.read(obj, [handle.group for handle in obj.tug.handles])
        for obj in (first, second)
    )
    np.testing.assert_array_equal(first_weights, second_weights)


def test_a_thread_that_is_cancelled_leaves_the_scene_as_it_was():
    def stop(stage, fraction):
        raise KeyboardInterrupt

    obj = add_rig()
    before = state(obj)
    job = rig.plan_bind(obj)
    thread = InThread(job, stop)
    thread.join()
    assert isinstance(thread.problem, KeyboardInterrupt)
    assert job.built is None
    assert state(obj) == before
    with pytest.raises(ValueError, match="has not been built"):
        rig.finish_bind(obj, job)


def test_what_cannot_be_bound_is_told_by_the_part_that_finds_it():
    obj = add_tube()
    with pytest.raises(RigError, match="needs at least two handles"):
        rig.plan_bind(obj)
    obj = add_rig("Pinched")
    positions = shape_keys.coordinates(key(obj, "Basis"))
    positions[33] = positions[34] = positions[44]
    shape_keys.write(obj.data, key(obj, "Basis"), positions)
    thread = InThread(rig.plan_bind(obj))
    thread.join()
    assert isinstance(thread.problem, RigError)
    assert str(thread.problem).startswith('"Pinched" cannot be bound:')


def test_handles_may_be_pulled_while_a_job_is_built():
    obj = add_rig()
    job = built_in_thread(rig.plan_bind(obj))
    pull_to(obj, "Swell")
    rig.finish_bind(obj, job)
    assert_close(evaluated(obj), expected(obj))


def sculpt(obj):
    positions = shape_keys.coordinates(key(obj, "Bend"))
    positions[50] += 0.1
    shape_keys.write(obj.data, key(obj, "Bend"), positions)


@pytest.mark.parametrize(
    "edit",
    [
        sculpt,
        lambda obj: rig.add_handle(obj, 40, "Fourth"),
        lambda obj: setattr(obj.tug.handles["Tip"], "vertex", 151),
        lambda obj: bpy.data.objects.remove(bpy.data.objects["Middle"]),
        lambda obj: setattr(obj.tug, "squared", True),
        lambda obj: setattr(obj.tug, "group_count", 3),
        lambda obj: setattr(obj.tug, "follow_nearest", True),
        lambda obj: setattr(key(obj, "Bend"), "name", "Bow"),
        lambda obj: obj.vertex_groups["Tip"].add([3], 0.5, "REPLACE"),
    ],
)
def test_a_job_is_not_finished_on_an_object_that_was_edited_meanwhile(edit):
    obj = bound_rig(dictionary="HANDLES")
    job = built_in_thread(rig.plan_bind(obj))
    edit(obj)
    bpy.context.view_layer.update()  # the rig is posed anew
    before = state(obj)
    with pytest.raises(RigError, match='"Tube" was edited while it was being bound: bind it again'):
        rig.finish_bind(obj, job)
    assert state(obj) == before


def test_a_job_is_not_finished_on_another_object():
    first, second = add_rig("First", "first "), add_rig("Second", "second ")
    job = built_in_thread(rig.plan_bind(first))
    with pytest.raises(RigError, match='"Second" was edited'):
        rig.finish_bind(second, job)
