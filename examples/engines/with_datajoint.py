# Rows in a database (PostgreSQL, MySQL) by DataJoint: python with_datajoint.py data/*.csv.
import sys

import datajoint as dj

import tissue_probe as tp

schema = dj.Schema("palpation")


@schema
class Recording(dj.Manual):
    definition = "path : varchar(255)"


@schema
class Answer(dj.Computed):
    definition = "-> Recording\n---\nstatus : varchar(16)\nstiffness = null : float64"

    def make(self, key):
        self.insert1(tp.row(key["path"], force_polarity="compression"), ignore_extra_fields=True)


Recording.insert([{"path": path} for path in sys.argv[1:]], skip_duplicates=True)
Answer.populate()
