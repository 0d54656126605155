"""What requests hold; the OpenAPI description is made of it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

Name = Annotated[str, StringConstraints(pattern=r"^[\w][\w .@'\-]{0,39}$", max_length=40)]
"""Of a person, for the record."""
RequestId = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_\-]{8,64}$")]
"""Made by the client, a new one for each act: the same one twice is answered twice and done once."""
Secret = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_\-]{1,80}$")]
"""Proves who holds the controls; given when they are taken."""
RunId = Annotated[str, StringConstraints(pattern=r"^[0-9A-Za-z\-]{1,40}$")]
"""Of a run, as the state gives it."""
PlaceName = Annotated[str, StringConstraints(pattern=r"^[\w][\w .+\-]{0,99}$", max_length=100)]
"""Of a folder or file, never a path."""
Identity = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{16}$")]
"""Of a point, by content."""


class Body(BaseModel):
    """A request; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", strict=True)


class Act(Body):
    """An act of whoever holds the controls."""

    request_id: RequestId
    secret: Secret


class RunAct(Act):
    """An act on the run that goes on: refused if meanwhile it is another."""

    run: RunId


class ResetAct(Act):
    """Reset after the run that ended last, as the caller knows it; None where nothing was run yet."""

    run: RunId | None


class PointAct(RunAct):
    """An act on one point."""

    point: Identity


class NoteAct(RunAct):
    """A remark for the recording."""

    text: Annotated[str, StringConstraints(min_length=1, max_length=500)]


class Stop(Body):
    """STOP: anybody may, at any time; name and time are for the record only.

    ``pressed_at_ns`` is when it was pressed, Unix time in ns, stamped once by whoever took the press.
    """

    by: Name = "somebody"
    pressed_at_ns: Annotated[int, Field(ge=0, le=2**63 - 1)] | None = None


class Take(Body):
    """Take the controls; ``taken_from`` names who holds them, where somebody does."""

    request_id: RequestId
    name: Name
    taken_from: Name | None = None


class Keep(Body):
    """A sign of life of whoever holds the controls."""

    secret: Secret


class Offer(Act):
    """Hand the controls over to someone by name."""

    to: Name


class NewRun(Body):
    """A campaign to be run: a name the service offers, or the text of a TOML file.

    Without the secret of the controls the run is proposed: whoever holds them lets it begin. ``twin``: id of the
    analysis whose model watches it; ``twin_pause``: no further point begins when it no longer holds.
    """

    request_id: RequestId
    secret: Secret | None = None
    name: Name
    campaign: PlaceName | None = None
    text: Annotated[str, StringConstraints(min_length=1, max_length=200_000)] | None = None
    folder: PlaceName | None = None
    real_time: bool = False
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    twin: RunId | None = None
    twin_pause: bool = False


class Jog(Act):
    """Turn the bench by hand: ``velocity`` of the load side in rad/s, slow (``jog_speed`` of the state at most)."""

    velocity: Annotated[float, Field(ge=-100.0, le=100.0)]


class Tare(Act):
    """Take the torque sensor's zero: at rest, without torque."""


class Hold(Body):
    """The button of a motion by hand is still held, or (``held`` false) no longer."""

    secret: Secret
    run: RunId
    held: bool = True


class BookRemark(Body):
    """A remark for the record book, whether anything runs or not."""

    request_id: RequestId
    name: Name
    text: Annotated[str, StringConstraints(min_length=1, max_length=500)]


class Draft(Body):
    """A campaign that is being written: its TOML text, or the table that text would hold."""

    text: Annotated[str, StringConstraints(min_length=1, max_length=200_000)] | None = None
    table: dict[str, Any] | None = None


class SaveCampaign(Draft):
    """Save a draft as a campaign of the laboratory; ``replaces`` keeps the version before beside it."""

    request_id: RequestId
    name: Name
    campaign: PlaceName
    replaces: bool = False


class NewInvestigation(Body):
    """What an investigation may cost and has to reach; see ``bench investigate``."""

    hours: Annotated[float, Field(ge=0.0, le=1000.0)] = 8.0
    experiments: Annotated[int, Field(ge=0, le=100)] = 5
    confidence: Annotated[float, Field(ge=0.0, le=0.9)] = 0.7
    alone: bool = False
    """Whether experiments after the first begin without a yes, where the bench allows it."""
    real_time: bool = False


class NewAnalysis(Body):
    """An identification, a search for what the simulation leaves out, an investigation of what that left open, or a
    comparison of what was recorded before a change and since.

    ``investigation`` goes with the kind ``investigate``, ``since`` with ``compare``, and neither with another.
    """

    request_id: RequestId
    name: Name
    kind: Literal["identify", "mismatch", "investigate", "compare"]
    folder: PlaceName
    model: PlaceName | None = None
    """Id of the analysis whose model.json is the simulation; None for the nominal one, calibrated."""
    investigation: NewInvestigation | None = None
    since: PlaceName | None = None
    """Id of the first recording after the change; None for the one that the twin named."""


class NewNote(Body):
    """Something said of a recording or, without a file, of a whole folder; ``archive`` puts it aside, nothing more."""

    request_id: RequestId
    name: Name
    folder: PlaceName
    file: PlaceName | None = None
    kind: Literal["comment", "tag", "untag", "archive", "restore"]
    text: Annotated[str, StringConstraints(max_length=2000)] = ""


class Cancel(Body):
    """End an analysis."""

    request_id: RequestId
    name: Name


class ChooseModel(Body):
    """Draw the model of an analysis over the spectrum; None draws none."""

    request_id: RequestId
    analysis: PlaceName | None = None


class Session(Body):
    """Show the token once; a cookie stands for it afterwards."""

    token: Annotated[str, StringConstraints(min_length=1, max_length=200)]


class Problem(BaseModel):
    """Why something was refused, in one sentence."""

    problem: str


class Done(BaseModel):
    """What was done, in one sentence."""

    done: str


class Stopped(Done):
    """STOP was sent. ``run`` is what it was for, None where nothing ran; the first press for a run counts."""

    run: str | None
    by: str
    pressed_at_ns: int


class Taken(BaseModel):
    """The controls are yours: ``secret`` proves it, ``id`` is how the state names this holder, whatever their name."""

    secret: str
    id: str


class RunAnswer(BaseModel):
    """A run as it stands."""

    id: str
    state: str
    folder: str


class SavedCampaign(Done):
    """A campaign was saved, and is offered under this name."""

    campaign: str


class AnalysisAnswer(BaseModel):
    """An analysis as it stands."""

    id: str
    state: str
