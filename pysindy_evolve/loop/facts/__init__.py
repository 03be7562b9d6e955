"""What the loop came to: the outcome as data, and what it says of the records in numbers.

`outcome.py` is where to begin. Nothing here is a sentence: what settles a search decides by these
facts, and the report tells them.

==================  ==================================================================
the outcome
outcome             equations and errors before and after, the effects, the records
effect              one effect with its evidence; the errors of one model
of one model
residuals           measured derivative minus model, in percent of its standard deviation
start_noise         how far noise in the first state moves a free run
of the records
unidentified        declared parameters that the records do not determine
held_delays         delays of half a sampling time, as a held input acts
record_differences  a parameter, or the mean of a residual, differs between records
shared_lines        the residuals of all records share a frequency that no input has
==================  ==================================================================
"""
