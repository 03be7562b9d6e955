"""Terms that no name fits, grown by genetic programming.

`term_grower.py` is where to begin.

==============  =======================================================================
term_grower     searches in every other piece of the records, tests on those between
genetic_search  one search: genetic programming in each equation
seeds           the small terms that a search begins with
climbing        improves a term one factor at a time, its numbers tuned each time
naming          what was grown as candidates, under a name where one fits
levels          terms that begin at a level of a first-order state, such as an overflow
short_records   for short records: a fixed list of small terms in place of a search
==============  =======================================================================
"""
