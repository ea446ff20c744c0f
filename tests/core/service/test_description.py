# SPDX-License-Identifier: MIT
"""The service does what its description says; requests are made up from that description."""

from __future__ import annotations

import logging
from typing import Any

import pytest
import schemathesis
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import strategies as st
from schemathesis.core.result import Ok
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

CHECKS = (
    schemathesis.checks.not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
)


MANY = pytest.param(20, id="many", marks=pytest.mark.long)


@pytest.mark.parametrize("examples", [pytest.param(2, id="few"), MANY])
def test_made_up_requests_get_described_answers(client: TestClient, examples: int) -> None:
    logging.getLogger("shapegoogle.service").setLevel(logging.CRITICAL)
    described = client.get("/api/openapi.json").json()
    schema = schemathesis.openapi.from_dict(described)
    operations = [found.ok() for found in schema.get_all_operations() if isinstance(found, Ok)]
    # None that is described is left out, because a request to it cannot be made up.
    tried = {(operation.path, operation.method.upper()) for operation in operations}
    assert tried == {
        (path, method.upper()) for path, methods in described["paths"].items() for method in methods
    }
    for operation in operations:
        strategy: st.SearchStrategy[schemathesis.Case[Any]] = operation.as_strategy()

        @given(case=strategy)
        @settings(
            max_examples=examples,
            deadline=None,
            database=None,
            derandomize=True,
            phases=[Phase.generate],
            verbosity=Verbosity.quiet,
            suppress_health_check=list(HealthCheck),
        )
        def conforms(case: schemathesis.Case[Any]) -> None:
            arguments = case.as_transport_kwargs(base_url="http://localhost")
            arguments.pop("cookies", None)  # the service needs no token
            request = client.build_request(**arguments)
            try:
                request.read()
            except (AttributeError, TypeError):  # made up as a form that no client can send
                return
            answer = client.send(request)
            response = schemathesis.Response.from_any(answer)
            case.validate_response(response, checks=[*CHECKS])

        conforms()
