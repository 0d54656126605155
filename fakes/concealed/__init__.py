"""The examiner: folders of recordings with physics concealed in them, and the truth about each.

Written independently of the analyser and its library: nothing of ``bench`` is imported, and effects take other
mathematical forms than a library would try first. ``cases`` lists an exam, ``open_folder`` makes one folder.
"""

from fakes.concealed.catalogue import CaseSpec, cases, vocabulary
from fakes.concealed.exam import GROUPS
from fakes.concealed.folder import Folder, open_folder, with_strength

__all__ = ["GROUPS", "CaseSpec", "Folder", "cases", "open_folder", "vocabulary", "with_strength"]
