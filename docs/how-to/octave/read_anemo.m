function record = read_anemo(file)
% READ_ANEMO  A recording of anemo as a struct of columns, in MATLAB or Octave.
%
%   record = read_anemo('run.csv')      a recording, or any table of anemo
%   record = read_anemo('run.mat')      what savemat of scipy has written
%
% record.time_s, record.power_w_sector1, ... are columns of numbers, NaN where a cell is empty.
% record.event, record.state are cell arrays of text. Metadata is record.about, text by key; a .mat
% file has none.

  if endsWith(file, '.mat')
    record = doubles(load(file));
  elseif endsWith(file, '.csv')
    record = columns_of_text(file);
  else
    error('read_anemo: %s is neither .csv nor .mat: savemat of scipy makes .mat of .parquet', file);
  end
end

% Columns of 32 bit and of bits become double, as of a .csv file.
function record = doubles(record)
  names = fieldnames(record);
  for k = 1:numel(names)
    if isnumeric(record.(names{k}))
      record.(names{k}) = double(record.(names{k}));
    end
  end
  record.about = struct();
end

function record = columns_of_text(file)
  lines = strsplit(strrep(fileread(file), char(13), ''), char(10));
  lines(cellfun(@isempty, lines)) = [];
  remark = strncmp(lines, '#', 1);
  record = struct('about', about(lines(remark)));
  lines(remark) = [];
  names = strsplit(lines{1}, ',');
  cells = strsplit(strjoin(lines(2:end), ','), ',', 'CollapseDelimiters', false);
  if numel(cells) ~= numel(names) * (numel(lines) - 1)
    error('read_anemo: %s has a comma in a cell, or rows of another length: read it as .mat', file);
  end
  cells = reshape(cells, numel(names), [])';
  for k = 1:numel(names)
    column = cells(:, k);
    numbers = str2double(column);
    % Text is what is neither a number nor empty.
    if any(isnan(numbers) & ~cellfun(@isempty, column) & ~strcmpi(column, 'nan'))
      record.(names{k}) = strrep(column, '"', '');
    else
      record.(names{k}) = numbers;
    end
  end
end

function texts = about(remarks)
  texts = struct();
  for k = 1:numel(remarks)
    parts = regexp(remarks{k}, '^#\s*([A-Za-z]\w*): (.*)$', 'tokens', 'once');
    if ~isempty(parts)
      texts.(parts{1}) = strrep(parts{2}, '\n', char(10));
    end
  end
end
