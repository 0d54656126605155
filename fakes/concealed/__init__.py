"""The examiner: folders of recordings with physics concealed in them, and the truth about each.

Written independently of the analyser and its library: nothing of ``bench`` is imported, and effects take other
mathematical forms than a library would try first. ``cases`` lists an exam, ``open_folder`` makes one folder.
"""

from fakes.concealed.catalogue import CaseSpec, cases, vocabulary
from fakes.concealed.exam import GROUPS
from fakes.concealed.folder import Folder, open_folder, with_strength
from fakes.concealed.watched import CHANGES, known_by, watched

__all__ = [
    "CHANGES",
    "GROUPS",
    "CaseSpec",
    "Folder",
    "cases",
    "known_by",
    "open_folder",
    "vocabulary",
    "watched",
    "with_strength",
]
