from __future__ import annotations

from pathlib import Path

import pytest

from bench.identification import Identification, Options, identify_folder
from tests.bench.identification.synthetic import campaign


@pytest.fixture(scope="session")
def campaign_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    campaign(folder, weak=True)
    return folder


@pytest.fixture(scope="session")
def found(campaign_folder: Path) -> Identification:
    return identify_folder(campaign_folder, Options())
