"""How soon the twin sees a change, and how often it sees one that is not there."""
