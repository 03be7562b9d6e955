"""Terms that no name fits, grown by genetic programming.

`term_grower.py` is where to begin.

==============  =======================================================================
term_grower     searches in every other piece of the records, tests on the pieces between
genetic_search  one search: genetic programming in each equation
seeds           small terms that a search starts from
curves          powers, Hill functions, steps and lengths, whose numbers a search seldom hits
climbing        improves a term factor by factor, its numbers tuned each time
declared_sums   declared sums times a function, and functions of them
naming          turns grown terms into candidates, named where a name fits
levels          terms that begin at a level of a first-order state, such as an overflow
short_records   for short records: a fixed list of small terms in place of a search
==============  =======================================================================
"""
