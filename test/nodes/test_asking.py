"""A question is put again until it is answered: requests are lost while nodes find each other."""

from __future__ import annotations

import pytest
import rclpy
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from std_srvs.srv import Trigger

from tissue_probe.nodes import asking
from tissue_probe.nodes.asking import ask, change_state


@pytest.fixture(autouse=True)
def soon(monkeypatch) -> None:
    monkeypatch.setattr(asking, "REPEAT", 0.2)


def serve(node, kind, name, answer):
    def on_request(request, response):
        answer(request, response)
        return response

    return node.create_service(kind, name, on_request)


def agree(request, response) -> None:
    response.success = True


def test_a_service_that_ended_before_it_answered_is_asked_again_when_it_is_back(graph):
    deaf = rclpy.create_node("deaf", namespace="/probe")  # no executor runs it
    serve(deaf, Trigger, "tare", agree)
    client = graph.node.create_client(Trigger, "tare")
    question = asking.to_service(client, Trigger.Request())
    graph.wait_until(client.service_is_ready)
    assert not question.is_answered()
    deaf.destroy_node()
    graph.wait_until(lambda: not client.service_is_ready())
    serve(graph.node, Trigger, "tare", agree)
    graph.wait_until(question.is_answered)
    assert question.answer().success
    assert question.is_repeated


def test_the_answer_of_a_service_that_hears_at_once_is_the_first(graph):
    heard = []
    serve(graph.node, Trigger, "tare", lambda request, response: heard.append(request))
    answer = ask(graph.node, Trigger, "tare", Trigger.Request(), graph.wait_until)
    assert not answer.success
    assert len(heard) == 1


@pytest.mark.parametrize(
    ("state", "made"), [(State.PRIMARY_STATE_INACTIVE, True), (State.PRIMARY_STATE_ACTIVE, False)]
)
def test_a_transition_that_is_asked_for_twice_was_made_if_the_node_is_in_its_state(
    graph, state, made
):
    """The second request is refused, since the first one was heard: only its answer was lost."""

    def tell(request, response) -> None:
        response.current_state.id = state

    late = rclpy.create_node("late", namespace="/probe")
    serve(late, ChangeState, "driver/change_state", lambda request, response: None)
    serve(graph.node, GetState, "driver/get_state", tell)
    executor = rclpy.executors.SingleThreadedExecutor()
    asked = 0

    def wait(condition) -> None:
        nonlocal asked
        while not condition():
            asked += 1
            # It answers only when it has been asked for half a second: twice at least.
            if asked > 25 and late not in executor.get_nodes():
                executor.add_node(late)
            if asked > 25:
                executor.spin_once(timeout_sec=0.01)
            graph.spin_once()
            assert asked < 2000, "waited in vain"

    transition = Transition.TRANSITION_CONFIGURE
    assert change_state(graph.node, "driver", transition, wait) is made
    late.destroy_node()
